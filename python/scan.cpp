#include "python/scan.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "app/config/config_load.h"
#include "app/config/outputs.h"
#include "app/report/report_json.h"
#include "app/report/run.h"
#include "python/arrays.h"
#include "scan/scan.h"

namespace py = pybind11;

namespace scanknit {
namespace {

/// Tells Python of progress and warnings. Python runs in the thread that scans.
class PythonObserver final : public ScanObserver {
 public:
  PythonObserver(py::object progress, py::object warning)
      : progress_(std::move(progress)), warning_(std::move(warning)) {}

  void on_progress(std::string_view what, std::size_t done, std::size_t total) override {
    const py::gil_scoped_acquire python;
    call([&] {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();  // Ctrl-C
      if (progress_.is_none()) return;
      const py::object goes_on = progress_(std::string(what), done, total);
      if (goes_on.is(py::bool_(false))) stop_.request_stop();
    });
  }

  void on_warning(const ScanWarning& warning) override {
    const py::gil_scoped_acquire python;
    call([&] {
      if (!warning_.is_none()) warning_(warning);
    });
  }

  [[nodiscard]] std::stop_token stop() const { return stop_.get_token(); }

  /// What a callback raised.
  void rethrow() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  /// An exception must not pass through the scan: it ends the frames, and is raised afterwards.
  template <typename Call>
  void call(const Call& python_call) {
    if (raised_) return;
    try {
      python_call();
    } catch (...) {
      raised_ = std::current_exception();
      stop_.request_stop();
    }
  }

  py::object progress_, warning_;
  std::stop_source stop_;
  std::exception_ptr raised_;
};

ScanJob job_for(const std::filesystem::path& recording, const std::filesystem::path& output,
                const std::vector<std::string>& presets, const std::vector<std::string>& settings) {
  ConfigSources sources;
  sources.starts_from_run_defaults = true;
  sources.presets = presets;
  sources.assignments = settings;
  const LoadedConfig loaded = value_or_throw(load_config(sources));
  OutputRequest request;
  request.output = output;
  Outputs outputs = value_or_throw(plan_outputs(request, loaded.config.output));
  outputs.report.reset();  // the result is returned
  outputs.page.reset();
  ScanJob job = job_of(recording, loaded, outputs);
  job.measures_fit = outputs.scan.error.has_value();
  return job;
}

/// `json` as Python's own objects.
py::object loaded_json(const std::string& json) {
  return py::module_::import("json").attr("loads")(json);
}

py::list poses_of_frames(const Trajectory& trajectory) {
  py::list poses;
  for (const PosedFrame& frame : trajectory) {
    poses.append(py::make_tuple(frame.sequence, matrix_of(frame.T_world_camera)));
  }
  return poses;
}

py::dict scan(const std::filesystem::path& recording, const std::filesystem::path& output,
              const std::vector<std::string>& presets, const std::vector<std::string>& settings,
              const py::object& progress, const py::object& warning) {
  const auto begin = std::chrono::steady_clock::now();
  const ScanJob job = job_for(recording, output, presets, settings);
  PythonObserver observer(progress, warning);
  ScanResult result;
  {
    const py::gil_scoped_release others_run;
    result = scan_recording(job, observer, observer.stop());
  }
  observer.rethrow();
  if (!result.outcome) throw Failure(result.outcome.error());
  py::dict summary;
  summary["files"] = result.files;
  summary["frames"] = py::dict(py::arg("read") = result.frames.read, py::arg("fused") = result.frames.fused,
                               py::arg("dropped") = result.frames.dropped, py::arg("lost") = result.frames.lost);
  summary["poses"] = poses_of_frames(result.trajectory);
  summary["warnings"] = result.warnings;
  summary["triangles"] = result.mesh.check ? result.mesh.check->triangles : 0;
  summary["is_turntable"] = result.turntable && result.turntable->is_refined;
  const bool was_ended = observer.stop().stop_requested();
  summary["report"] = loaded_json(report_json(close_run(std::move(result), was_ended, begin)));
  return summary;
}

}  // namespace

void add_scan(py::module_& module) {
  py::class_<ScanWarning>(module, "ScanWarning",
                          "A problem that did not end a scan. code: what it is about, as scan/scan_result.h names it "
                          "(\"tracking_lost\"); text, also str(): for the user.")
      .def_property_readonly("code", [](const ScanWarning& warning) { return to_string(warning.code); })
      .def_readonly("text", &ScanWarning::text)
      .def("__str__", [](const ScanWarning& warning) { return warning.text; })
      .def("__repr__", [](const ScanWarning& warning) {
        return std::string("<ScanWarning ") + to_string(warning.code) + ": " + warning.text + ">";
      });
  module.def(
      "scan", &scan, py::arg("recording"), py::arg("output"), py::kw_only(),
      py::arg("presets") = std::vector<std::string>(), py::arg("settings") = std::vector<std::string>(),
      py::arg("progress") = py::none(), py::arg("warning") = py::none(),
      "Scans a recording as `scanknit run` does, and writes the same files, but for the report.\n\n"
      "output: a folder, or one mesh file. presets: names, as --preset takes them. settings: \"key=value\", as\n"
      "--set takes them. progress(what, done, total): called between frames; False ends the frames, and what "
      "has\n"
      "been fused becomes the mesh. warning(ScanWarning): called for each warning.\n"
      "Returns a dict: files (kind to path), frames (counts), poses (number and 4 x 4 matrix of each frame in "
      "the\nmesh), warnings, triangles, is_turntable, report (what report.json has: docs/report.md). Raises Error.");
}

}  // namespace scanknit
