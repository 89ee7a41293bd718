#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "app/calibrate/calibrate_arguments.h"
#include "app/calibrate/found_views.h"
#include "app/calibrate/rig_text.h"
#include "app/calibrate/target_file.h"
#include "app/config/config_camera.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"
#include "calibrate/board/board_pictures.h"
#include "calibrate/calibrate_camera.h"
#include "calibrate/rig/calibrate_rig.h"
#include "core/files/atomic_file.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

using RigJson = nlohmann::ordered_json;

/// Pictures are interpolated: more are looked at than one camera's calibration needs.
constexpr std::size_t kMostRigPictures = 1200;

/// The board before one camera.
struct SeenBoard {
  std::string name = {};
  FoundViews found = {};
  std::vector<std::optional<std::int64_t>> stamps_ns = {};  ///< of the views
  std::vector<std::uint64_t> sequences = {};
  BoardPictures pictures = {};
  std::shared_ptr<const ScannerCamera> camera = nullptr;  ///< --camera
};

Error at_recording(const Error& error, const std::string& name) {
  return {error.code, error.where.empty() ? error.message : error.where + ": " + error.message, name};
}

Result<SeenBoard> look_for_board(const std::filesystem::path& recording, const AcquireConfig& acquire,
                                 const CalibrationTarget& target, Console& console, const std::stop_token& stop) {
  SeenBoard seen{.name = recording.string()};
  std::size_t looked_at = 0;
  const auto take = [&](const BoardPicture& picture) -> Result<void> {
    console.progress("looking for the board in " + seen.name, ++looked_at, std::max(looked_at, picture.expected));
    const std::size_t before = seen.found.views.size();
    if (auto done = look_at(picture, target, seen.found); !done) return done;
    if (seen.found.views.size() == before) return {};
    seen.stamps_ns.push_back(picture.timestamp_ns);
    seen.sequences.push_back(picture.sequence);
    return {};
  };
  auto pictures = read_board_pictures(recording, acquire, take, stop, kMostRigPictures);
  if (!pictures) return at_recording(pictures.error(), seen.name);
  seen.pictures = *std::move(pictures);
  if (seen.pictures.was_stopped) return seen;
  if (!seen.pictures.is_recording) {
    return Error{ErrorCode::kInput, "is a folder of pictures; expected a recording, which has times", seen.name};
  }
  if (const auto fault = why_unseen(seen.found, seen.pictures.read, seen.name)) return *fault;
  return seen;
}

/// The camera of the pictures that a CAMERA.yaml states.
Result<CameraModel> stated_lens(const ScannerCamera& camera, const SeenBoard& seen) {
  const PictureSize size = seen.found.size;
  std::optional<CameraModel> lens = camera.colour;
  if (!lens && camera.depth && seen.pictures.registered_depth) {
    lens = CameraModel{camera.depth->intrinsics.resized(size.width, size.height), camera.depth->distortion};
  }
  if (lens && lens->intrinsics.width == size.width && lens->intrinsics.height == size.height) return *lens;
  return Error{ErrorCode::kConfig,
               fmt::format("has no camera for the pictures of {}, which are {} x {}; expected colour: of that size",
                           seen.name, size.width, size.height),
               camera.file};
}

/// What the estimate is given of a camera. Times count from `begin_ns`.
Result<RigRecording> rig_recording(const SeenBoard& seen, const CalibrationTarget& target, std::int64_t begin_ns) {
  RigRecording recording{.name = seen.name, .is_lens_known = seen.camera != nullptr};
  std::vector<std::size_t> sharp;
  if (seen.camera) {
    const auto lens = stated_lens(*seen.camera, seen);
    if (!lens) return lens.error();
    recording.lens = *lens;
    sharp = sharp_views(seen.found.views);
  } else {
    auto calibration = calibrate_camera(seen.found.views, target, seen.found.size);
    if (!calibration) return at_recording(calibration.error(), seen.name);
    recording.lens = calibration->camera;
    sharp = std::move(calibration->sharp);
  }
  recording.has_clock = std::ranges::all_of(seen.stamps_ns, [](const auto& stamp) { return stamp.has_value(); });
  for (const std::size_t view : sharp) {
    const double time_s = recording.has_clock
                              ? (static_cast<double>(*seen.stamps_ns[view]) - static_cast<double>(begin_ns)) * 1e-9
                              : static_cast<double>(seen.sequences[view]);
    recording.views.push_back({time_s, seen.found.views[view].corners});
  }
  return recording;
}

/// T_colour_depth of a camera.
Pose depth_in_colour(const SeenBoard& seen) {
  const auto stated = seen.camera ? seen.camera->T_colour_depth : std::nullopt;
  return stated.value_or(seen.pictures.T_colour_depth);
}

/// The estimate is of the pictures' cameras, colour; a rig is of depth's.
std::vector<RigEntry> entries_of(const RigCalibration& found, const std::vector<SeenBoard>& seen) {
  std::vector<RigEntry> entries;
  const Pose T_depth_colour = depth_in_colour(seen.front()).inverse();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    RigEntry entry{.recording = seen[i].name};
    if (i > 0) entry.T_rig_camera = T_depth_colour * found.cameras[i].T_rig_camera * depth_in_colour(seen[i]);
    if (seen[i].camera) {
      entry.camera_file = seen[i].camera->file;
    } else {
      entry.camera = cameras_of(found.cameras[i].lens, seen[i].pictures, false);
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

RigJson rig_json(const RigCalibration& found, const std::vector<RigEntry>& entries, const std::string& output) {
  RigJson cameras = RigJson::array();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const FoundCamera& camera = found.cameras[i];
    const Eigen::Vector3d& t = entries[i].T_rig_camera.translation();
    const Eigen::Quaterniond q(entries[i].T_rig_camera.linear());
    cameras.push_back({{"recording", entries[i].recording},
                       {"T_rig_camera", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}},
                       {"position_deviation_m", camera.position_deviation_m},
                       {"turn_deviation_rad", camera.turn_deviation_rad},
                       {"clock_offset_ms", 1000 * camera.clock_offset_s},
                       {"clock_deviation_ms", 1000 * camera.clock_deviation_s},
                       {"shared_moments", camera.shared_moments},
                       {"error_px", camera.error_px}});
  }
  return {{"output", output},
          {"cameras", cameras},
          {"moments", found.moments},
          {"outlying_corners", found.outlying_corners},
          {"error_px", found.error_px}};
}

std::string rig_summary(const RigCalibration& found, const std::vector<RigEntry>& entries) {
  std::string text =
      fmt::format("Board    seen by two cameras or more at {} moments; {:.3f} pixels (root mean square)\n",
                  found.moments, found.error_px);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const FoundCamera& camera = found.cameras[i];
    const Eigen::Vector3d t_mm = 1000 * entries[i].T_rig_camera.translation();
    text += fmt::format(
        "Camera   {:.1f} {:.1f} {:.1f} mm +- {:.2g} mm, {:.2g} degrees; its clock + {:.2f} +- {:.2g} ms: {}\n",
        t_mm.x(), t_mm.y(), t_mm.z(), 1000 * camera.position_deviation_m, camera.turn_deviation_rad / kDegree,
        1000 * camera.clock_offset_s, 1000 * camera.clock_deviation_s, entries[i].recording);
  }
  return text;
}

void warn_of_doubt(const RigCalibration& found, const std::vector<RigEntry>& entries, bool has_clock,
                   Console& console) {
  constexpr double kMostShift_m = 0.001, kMostTurn_rad = 0.1 * kDegree, kMostClock_s = 0.001;
  for (std::size_t i = 1; i < entries.size(); ++i) {
    const FoundCamera& camera = found.cameras[i];
    if (camera.position_deviation_m > kMostShift_m || camera.turn_deviation_rad > kMostTurn_rad) {
      console.warn(
          fmt::format("{}: the camera's pose is known to +- {:.1f} mm and {:.2f} degrees only; move the board "
                      "slowly through all of the room that it shares with the others, and tilt it",
                      entries[i].recording, 1000 * camera.position_deviation_m, camera.turn_deviation_rad / kDegree));
    }
    if (has_clock && camera.clock_deviation_s > kMostClock_s) {
      console.warn(
          fmt::format("{}: its clock is known to +- {:.1f} ms only; move the board, in pictures at 8 Hz or more",
                      entries[i].recording, 1000 * camera.clock_deviation_s));
    }
  }
}

/// The files of --camera; empty if none is given.
Result<std::vector<std::shared_ptr<const ScannerCamera>>> read_cameras(const CalibrateRigArguments& arguments) {
  std::vector<std::shared_ptr<const ScannerCamera>> cameras;
  if (!arguments.cameras.empty() && arguments.cameras.size() != arguments.recordings.size()) {
    return Error{ErrorCode::kUsage, fmt::format("--camera is given {} times for {} recordings; expected once for each, "
                                                "or never",
                                                arguments.cameras.size(), arguments.recordings.size())};
  }
  for (const auto& file : arguments.cameras) {
    YamlNode name;
    name.kind = YamlNode::Kind::kScalar;
    name.text = file.string();
    std::string fault;
    auto camera = read_scanner_camera_file(name, {}, [&](const YamlNode&, const std::string& what) { fault = what; });
    if (!camera) return Error{ErrorCode::kConfig, fault};
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

/// Looks at all recordings. Empty when it was stopped.
Result<std::vector<SeenBoard>> look_at_recordings(const CalibrateRigArguments& arguments, const AcquireConfig& acquire,
                                                  const CalibrationTarget& target, Console& console,
                                                  const std::stop_token& stop) {
  auto cameras = read_cameras(arguments);
  if (!cameras) return cameras.error();
  std::vector<SeenBoard> all;
  for (std::size_t i = 0; i < arguments.recordings.size(); ++i) {
    auto seen = look_for_board(arguments.recordings[i], acquire, target, console, stop);
    if (!seen) return seen.error();
    if (seen->pictures.was_stopped) return std::vector<SeenBoard>();
    if (!cameras->empty()) seen->camera = (*cameras)[i];
    all.push_back(*std::move(seen));
  }
  return all;
}

Result<RigCalibration> calibrate_seen(const std::vector<SeenBoard>& seen, const CalibrationTarget& target) {
  std::vector<RigRecording> recordings;
  const std::int64_t begin_ns = seen.front().stamps_ns.front().value_or(0);
  for (const SeenBoard& board : seen) {
    auto recording = rig_recording(board, target, begin_ns);
    if (!recording) return recording.error();
    recordings.push_back(*std::move(recording));
  }
  return calibrate_rig(recordings, target);
}

}  // namespace

int calibrate_rig_command(const CalibrateRigArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(common.config);
  if (!loaded) return fail(loaded.error(), common);
  const auto target = read_target_file(arguments.target);
  if (!target) return fail(target.error(), common);
  if (auto ready = check_writable(arguments.output); !ready) return fail(ready.error(), common);
  Console console(common.verbosity);
  const auto seen = look_at_recordings(arguments, loaded->config.acquire, *target, console, stop_on_signal.token());
  if (!seen) return fail(seen.error(), common);
  if (seen->empty()) return kExitInterrupted;
  const auto found = calibrate_seen(*seen, *target);
  if (!found) return fail(found.error(), common);
  const auto entries = entries_of(*found, *seen);
  if (auto done = write_file_atomically(arguments.output, rig_text(*found, entries)); !done) {
    return fail(done.error(), common);
  }
  warn_of_doubt(*found, entries, seen->front().stamps_ns.front().has_value(), console);
  const std::string output = arguments.output.string();
  std::string text;
  if (common.is_json) {
    text = rig_json(*found, entries, output).dump(2, ' ', false, RigJson::error_handler_t::replace) + "\n";
  } else if (common.verbosity != Verbosity::kQuiet) {
    text = rig_summary(*found, entries) +
           fmt::format("Written  {0}\nNext     scanknit run RECORDING RECORDING ... --rig {0} -o OUT\n", output);
  }
  return text.empty() ? kExitOk : print_result(text, common);
}

}  // namespace scanknit
