#include "python/observer.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <string>
#include <thread>

#include "python/arrays.h"
#include "python/errors.h"

namespace py = pybind11;

namespace scanknit {
namespace {

using Kind = ScanCommand::Kind;

constexpr std::pair<const char*, Kind> kCommands[] = {{"start", Kind::kStart},   {"pause", Kind::kPause},
                                                      {"reset", Kind::kReset},   {"crop", Kind::kCrop},
                                                      {"export", Kind::kExport}, {"finish", Kind::kFinish}};

const char* name_of(Kind kind) {
  for (const auto& [name, named] : kCommands) {
    if (named == kind) return name;
  }
  return "";
}

CropBox box_of(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  using Corner = std::array<double, 3>;
  std::pair<Corner, Corner> corners;
  try {
    corners = given.cast<std::pair<Corner, Corner>>();
  } catch (const py::cast_error&) {
    throw py::type_error("command: a box to crop to is a pair of corners, of three numbers each");
  }
  const Eigen::AlignedBox3d box(Eigen::Vector3d(corners.first.data()), Eigen::Vector3d(corners.second.data()));
  if ((box.min().array() < box.max().array()).all()) return box;  // NaN is not
  throw py::value_error("command: of a box to crop to, the first corner is the lower one on every axis");
}

/// "pause", or ("crop", box).
ScanCommand command_of(const py::object& given) {
  const bool has_box = py::isinstance<py::tuple>(given) && py::len(given) == 2;
  const py::object word = has_box ? py::object(given[py::int_(0)]) : given;
  for (const auto& [name, kind] : kCommands) {
    if (!word.equal(py::str(name)) || has_box != (kind == Kind::kCrop)) continue;
    return {kind, has_box ? box_of(given[py::int_(1)]) : CropBox()};
  }
  const auto text = py::repr(given).cast<std::string>();
  throw py::value_error("command: expected None, 'start', 'pause', 'reset', 'export', 'finish' or ('crop', box), got " +
                        text);
}

}  // namespace

/// An exception must not pass through the scan: it ends the frames, and is raised afterwards.
template <typename Call>
void PythonObserver::call(const Call& python_call) {
  const py::gil_scoped_acquire python;
  if (raised_) return;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();  // Ctrl-C
    python_call();
  } catch (...) {
    raised_ = std::current_exception();
    stop_.request_stop();
  }
}

void PythonObserver::on_progress(std::string_view what, std::size_t done, std::size_t total) {
  call([&] {
    if (!callbacks_.progress) return;
    const py::object goes_on = callbacks_.progress(std::string(what), done, total);
    if (goes_on.is(py::bool_(false))) stop_.request_stop();
  });
}

void PythonObserver::on_warning(const ScanWarning& warning) {
  call([&] {
    if (callbacks_.warning) callbacks_.warning(warning);
  });
}

void PythonObserver::on_frame(const Frame& frame, const std::optional<Pose>& T_world_camera, const ScanState&) {
  if (!callbacks_.frame) return;
  call([&] {
    const py::object pose = T_world_camera ? py::object(matrix_of(*T_world_camera)) : py::none();
    callbacks_.frame(frame.sequence, pose);
  });
}

std::optional<ScanCommand> PythonObserver::next_command(std::stop_token, std::chrono::nanoseconds patience) {
  // One command between two frames: a callable that goes on saying "pause" must not hold up the scan.
  std::optional<ScanCommand> command;
  if (!std::exchange(has_commanded_, false)) {
    call([&] {
      if (!callbacks_.command) return;
      const py::object given = callbacks_.command();
      if (!given.is_none()) command = command_of(given);
    });
  }
  has_commanded_ = command.has_value();
  constexpr std::chrono::nanoseconds kPause = std::chrono::milliseconds(20);
  if (!command) std::this_thread::sleep_for(std::min(patience, kPause));
  return command;
}

void PythonObserver::on_answer(const ScanCommand& command, const Result<void>& outcome, const FilesByKind&,
                               const ScanState&) {
  if (!callbacks_.answer) return;
  call([&] {
    const py::object error = outcome ? py::none() : error_object(Failure(outcome.error()));
    callbacks_.answer(name_of(command.kind), error);
  });
}

}  // namespace scanknit
