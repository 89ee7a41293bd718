#include "acquire/convert/convert_recording.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "acquire/convert/picture_files.h"
#include "acquire/convert/recording_target.h"
#include "acquire/new_recording.h"
#include "core/picture/jpeg_structure.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kUnitsWithoutRaw = 5000;  // of depth that was floating point: 0.2 mm, up to 13 m
constexpr std::int64_t kPeriod_ns = 33'333'333;

/// A folder that was new or empty, and is so again in the end unless it is kept: half a recording looks like a whole
/// one.
class NewFolder {
 public:
  NewFolder(fs::path path, bool was_there) : path_(std::move(path)), was_there_(was_there) {}
  ~NewFolder() {
    if (is_kept_) return;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(path_, ignored)) fs::remove_all(entry.path(), ignored);
    if (!was_there_) fs::remove(path_, ignored);
  }
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  void keep() { is_kept_ = true; }

 private:
  fs::path path_;
  bool was_there_;
  bool is_kept_ = false;
};

OpenedTarget open_target(ConvertTarget target, const fs::path& output, UpAxis world_up) {
  if (is_one_file(target)) {
    if (auto is_new = check_is_new_recording(output); !is_new) return is_new.error();
    return target == ConvertTarget::kRos2 ? open_ros2_target(output) : open_mcap_target(output);
  }
  std::error_code code;
  if (fs::exists(output, code) && (!fs::is_directory(output, code) || !fs::is_empty(output, code))) {
    return Error{ErrorCode::kOutput, "is there already and not an empty folder; give another -o", output.string()};
  }
  fs::create_directories(output, code);
  if (code) return Error{ErrorCode::kOutput, "cannot be made: " + code.message(), output.string()};
  switch (target) {
    case ConvertTarget::kTum: return open_tum_target(output);
    case ConvertTarget::kOpen3d: return open_open3d_target(output);
    case ConvertTarget::kSevenScenes: return open_seven_scenes_target(output);
    case ConvertTarget::kColmap: return open_colmap_target(output);
    case ConvertTarget::kNerfstudio: return open_nerfstudio_target(output, world_up);
    default: return open_fakenect_target(output);
  }
}

bool is_identity(const Pose& pose) {
  constexpr double kMetres = 1e-9;
  return (pose.matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff() < kMetres;
}

}  // namespace

void RecordingTarget::warn(const std::string& text) {
  if (std::find(warnings_.begin(), warnings_.end(), text) == warnings_.end()) warnings_.push_back(text);
}

ColourImage RecordingTarget::resample_colour(const Frame& frame) {
  warn("the layout has no colour camera of its own: colour is resampled into the depth pictures");
  return register_colour(frame);
}

Result<std::string> RecordingTarget::write_colour_file(const Frame& frame, const fs::path& folder,
                                                       const std::string& stem) {
  if (is_registered(frame)) return write_own_colour_file(*frame.colour, folder, stem);
  const std::string name = stem + ".png";
  auto done = write_colour_png(resample_colour(frame), folder / name);
  return done ? Result<std::string>(name) : done.error();
}

Result<std::string> RecordingTarget::write_own_colour_file(const ColourFrame& colour, const fs::path& folder,
                                                           const std::string& stem) {
  const bool is_jpeg = colour.encoded && looks_like_jpeg(*colour.encoded);
  const std::string name = stem + (is_jpeg ? ".jpg" : ".png");
  auto done =
      colour.encoded ? write_bytes(*colour.encoded, folder / name) : write_colour_png(colour.image, folder / name);
  return done ? Result<std::string>(name) : done.error();
}

bool is_registered(const Frame& frame) {
  constexpr double kPixels = 1e-6;
  const CameraIntrinsics& colour = frame.colour->intrinsics;
  const CameraIntrinsics expected = frame.intrinsics.resized(colour.width, colour.height);
  return is_identity(frame.colour->T_colour_depth) && std::abs(colour.fx - expected.fx) < kPixels &&
         std::abs(colour.fy - expected.fy) < kPixels && std::abs(colour.cx - expected.cx) < kPixels &&
         std::abs(colour.cy - expected.cy) < kPixels;
}

std::optional<ColouredPoint> coloured_point(const Frame& frame, int x, int y) {
  const ColourFrame& colour = *frame.colour;
  const double z = frame.depth_m.at(x, y);
  if (!(z > 0)) return std::nullopt;
  const Eigen::Vector3d p_depth = frame.intrinsics.unproject(x, y, z);
  const Eigen::Vector3d p_colour = colour.T_colour_depth * p_depth;
  if (!(p_colour.z() > 0)) return std::nullopt;
  const Eigen::Vector2d pixel = colour.intrinsics.project(p_colour);
  const bool is_inside = pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < colour.image.width() - 0.5 &&
                         pixel.y() < colour.image.height() - 0.5;
  if (!is_inside) return std::nullopt;
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  return ColouredPoint{p_depth, colour.image.at(u, v)};
}

ColourImage register_colour(const Frame& frame) {
  ColourImage seen(frame.depth_m.width(), frame.depth_m.height());
  for (int y = 0; y < seen.height(); ++y) {
    for (int x = 0; x < seen.width(); ++x) {
      if (const auto point = coloured_point(frame, x, y)) seen.at(x, y) = point->colour;
    }
  }
  return seen;
}

Result<ConvertSummary> convert_recording(FrameSource& source, ConvertTarget target, const fs::path& output,
                                         const ConvertProgress& progress, std::stop_token stop) {
  std::error_code code;
  const bool was_there = fs::exists(output, code);
  const auto opened = open_target(target, output, source.info().world_up);
  if (!opened) return opened.error();
  std::optional<NewFolder> folder;
  if (!is_one_file(target)) folder.emplace(output, was_there);
  RecordingTarget& recording = **opened;
  ConvertSummary summary;
  const double units = source.info().depth_scale.value_or(kUnitsWithoutRaw);
  std::optional<Error> first_drop;
  const auto leave_out = [&](Error why) {
    ++summary.dropped;
    if (!first_drop) first_drop = std::move(why);
  };
  for (;;) {
    FrameEvent event = source.next(stop);
    if (std::holds_alternative<EndOfStream>(event)) break;
    if (auto* error = std::get_if<Error>(&event)) return *std::move(error);
    if (auto* drop = std::get_if<FrameDropped>(&event)) {
      leave_out(std::move(drop->error));
      continue;
    }
    const Frame& frame = std::get<Frame>(event);
    if (auto refused = recording.refuses(frame)) {
      leave_out(*std::move(refused));
      continue;
    }
    const std::int64_t time_ns =
        frame.has_clock ? frame.timestamp_ns : static_cast<std::int64_t>(summary.frames) * kPeriod_ns;
    const auto raw = to_raw_depth(frame.depth_m, units);
    if (auto written = recording.write({frame, raw, units, summary.frames, time_ns}); !written) return written.error();
    ++summary.frames;
    if (frame.colour) ++summary.colour;
    if (frame.T_world_camera) ++summary.poses;
    if (progress) progress(summary.frames);
  }
  summary.was_stopped = stop.stop_requested();
  if (summary.frames == 0) {
    return first_drop ? *first_drop : Error{ErrorCode::kInput, "no frame to convert", source.info().folder.string()};
  }
  if (auto finished = recording.finish(); !finished) return finished.error();
  if (folder) folder->keep();
  summary.warnings = recording.warnings();
  if (!source.info().depth_scale) summary.warnings.emplace_back("depth had no raw units: it is rounded to 0.2 mm");
  if (first_drop) summary.warnings.push_back("frames were dropped, the first: " + first_drop->text());
  return summary;
}

}  // namespace scanknit
