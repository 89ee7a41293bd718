#include "python/scan.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "app/commands/mesh_command.h"
#include "app/report/report_json.h"
#include "app/report/run.h"
#include "python/arguments.h"
#include "python/arrays.h"
#include "python/errors.h"
#include "python/keywords.h"
#include "python/observer.h"

namespace py = pybind11;

namespace scanknit {
namespace {

using Path = std::filesystem::path;

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

/// What every function returns.
py::dict dict_of(const CommandRun& run) {
  const ScanResult& scan = run.scan;
  py::dict result;
  result["files"] = scan.files;
  result["frames"] = py::dict(py::arg("read") = scan.frames.read, py::arg("fused") = scan.frames.fused,
                              py::arg("dropped") = scan.frames.dropped, py::arg("lost") = scan.frames.lost);
  result["poses"] = poses_of_frames(scan.trajectory);
  result["warnings"] = scan.warnings;
  result["triangles"] = scan.mesh.check ? scan.mesh.check->triangles : 0;
  result["is_turntable"] = scan.turntable && scan.turntable->is_refined;
  result["report"] = loaded_json(report_json(run));
  return result;
}

/// What a caller wants to hear of; the last keywords to be read.
Callbacks read_callbacks(Keywords& keywords, bool has_frames) {
  Callbacks callbacks;
  keywords.read("progress", callbacks.progress);
  keywords.read("warning", callbacks.warning);
  if (has_frames) {
    keywords.read("frame", callbacks.frame);
    keywords.read("command", callbacks.command);
    keywords.read("answer", callbacks.answer);
  }
  keywords.refuse_others();
  return callbacks;
}

/// For Python what run_mesh_command() is for the program.
py::dict run(const MeshCommand& command, const Callbacks& callbacks) {
  const auto begin = std::chrono::steady_clock::now();
  LoadedConfig loaded = value_or_throw(load_config(command.config));
  succeed_or_throw(command.configure(loaded.config));
  const Outputs outputs = value_or_throw(plan_outputs(command.outputs, loaded.config.output));
  ScanJob job = job_of(command.input, loaded, outputs);
  job.files_of_caller.clear();  // the report is returned
  command.complete(job);
  PythonObserver observer(callbacks);
  ScanResult result;
  {
    const py::gil_scoped_release others_run;
    result = command.scan(job, loaded, observer, observer.stop());
  }
  observer.rethrow();
  if (!result.outcome) throw Failure(result.outcome.error());
  const bool was_interrupted = observer.stop().stop_requested() && !command.is_capture;
  return dict_of(close_run(std::move(result), was_interrupted, begin));
}

py::dict scan(const Path& recording, const Path& output, const py::kwargs& given) {
  Keywords keywords(given);
  const ConfigSources config = config_sources(keywords);
  const RunArguments arguments = run_arguments(recording, output, keywords);
  return run(mesh_command_of(arguments, config), read_callbacks(keywords, true));
}

py::dict capture(const Path& output, const py::kwargs& given) {
  Keywords keywords(given);
  const ConfigSources config = config_sources(keywords);
  const CaptureArguments arguments = capture_arguments(output, keywords);
  return run(mesh_command_of(arguments, config), read_callbacks(keywords, true));
}

py::dict align(const std::vector<Path>& inputs, const Path& output, const py::kwargs& given) {
  Keywords keywords(given);
  const ConfigSources config = config_sources(keywords);
  const AlignArguments arguments = align_arguments(inputs, output, keywords);
  return run(mesh_command_of(arguments, config), read_callbacks(keywords, false));
}

py::dict extract(const Path& volume, const Path& output, const py::kwargs& given) {
  Keywords keywords(given);
  ConfigSources config = config_sources(keywords);
  const ExtractArguments arguments = extract_arguments(volume, output, keywords, config);
  return run(mesh_command_of(arguments, config), read_callbacks(keywords, false));
}

void add_scan_warning(py::module_& module) {
  py::class_<ScanWarning>(module, "ScanWarning",
                          "A problem that did not end a scan. code: what it is about, as scan/scan_result.h names it "
                          "(\"tracking_lost\"); text, also str(): for the user.")
      .def_property_readonly("code", [](const ScanWarning& warning) { return to_string(warning.code); })
      .def_readonly("text", &ScanWarning::text)
      .def("__str__", [](const ScanWarning& warning) { return warning.text; })
      .def("__repr__", [](const ScanWarning& warning) {
        return std::string("<ScanWarning ") + to_string(warning.code) + ": " + warning.text + ">";
      });
}

// The first paragraph of each is the signature, since Python sees only **given.
constexpr const char* kScan = R"(scan(recording, output, *, presets=(), settings=(), first=0, last=None, every=1,
     angles=None, cut_recording=None, trajectory=None, save_volume=None,
     progress=None, warning=None, frame=None, command=None, answer=None)

Scans a recording as `scanknit run` does, and writes the same files, but for the report.

output: a folder, or one mesh file. presets: names, as --preset takes them. settings: "key=value", as --set takes
them. first, last (included), every: which frames. angles, cut_recording: files, of a turntable. trajectory,
save_volume: files to write besides.
progress(what, done, total): False ends the frames; what has been fused becomes the mesh, as it was tracked and without
a texture.
warning(ScanWarning). frame(number, pose): a frame was fused at this pose, (4, 4), or was lost: None.
command(): asked between two frames. None, "pause", "start" (goes on), "reset", "export" (writes the mesh so far),
"finish" (ends the frames), or ("crop", ((x, y, z), (x, y, z))), ("crop", None).
answer(command, error): how the command went; error: None or an Error.
Returns a dict: files (kind to path), frames (counts), poses (number and 4 x 4 matrix of each frame in the mesh),
warnings, triangles, is_turntable, report (what report.json has: docs/report.md). Raises Error.)";

constexpr const char* kCapture =
    R"(capture(output, *, device='', width=640, height=480, fps=30, frames=None, seconds=None,
        wait=0, reconnect=30, force=False, recording=True,
        presets=(), settings=(), trajectory=None, save_volume=None,
        progress=None, warning=None, frame=None, command=None, answer=None)

Scans with a scanner that is plugged in, as `scanknit capture` does. See scan() for all that is not said here.

device: as `scanknit devices` lists it; the first if empty. width, height, fps: the nearest that the camera has.
frames, seconds: ends after so many pictures, or so long; else when progress returns False or command "finish".
wait, reconnect: seconds to wait for a scanner that is not plugged in yet, or no more. force: also a scanner that
another program uses. recording: the raw pictures are kept beside the mesh (True), here (a path, .mcap), or not
(False). Raises Error, code "device", for a scanner that is absent, busy or forbidden.)";

constexpr const char* kAlign = R"(align(inputs, output, *, initial=None, markers=None, refine=False, points=None,
      presets=(), settings=(), trajectory=None, save_volume=None, progress=None, warning=None)

Brings several scans of one thing together and makes one mesh, as `scanknit align` does. See also scan().

inputs: recordings, range scans, meshes, point clouds, .conf. initial, markers: files of what is known of the poses.
refine: also correct the poses of a .conf or a PTX. points: file, .ply or .pcd, for the points of all scans.
progress: False ends the work with an Error while the scans are compared; while they are fused, those so far become
the mesh. The poses of the scans are in report["alignment"].)";

constexpr const char* kExtract = R"(extract(volume, output, *, isovalue=None, dims=None, type=None, spacing_mm=None,
        byte_order='little', header_bytes=0, presets=(), settings=(), progress=None, warning=None)

Makes a mesh of a volume file, as `scanknit extract` does. See also scan().

volume: OpenVDB, NRRD, MetaImage, NIfTI, raw samples, or a folder of DICOM, PNG or TIFF slices. isovalue: a number;
"auto": proposed from the values; None: that of the settings, or 0 for signed distances. Of raw samples: dims
(i fastest, j, k), type ("uint16", "float" ...), byte_order ("little", "big"), header_bytes; of these and of slices:
spacing_mm, one number or three.)";

}  // namespace

void add_scan(py::module_& module) {
  add_scan_warning(module);
  py::options options;
  options.disable_function_signatures();
  module.def("scan", &scan, py::arg("recording"), py::arg("output"), kScan);
  module.def("capture", &capture, py::arg("output"), kCapture);
  module.def("align", &align, py::arg("inputs"), py::arg("output"), kAlign);
  module.def("extract", &extract, py::arg("volume"), py::arg("output"), kExtract);
}

}  // namespace scanknit
