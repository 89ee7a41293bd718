// Polycam's raw data (github.com/PolyCam/polyform, README.md, "Polycam's data format"): the folder keyframes/.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "acquire/parse/json_numbers.h"
#include "acquire/parse/numbered_files.h"
#include "acquire/parse/opengl_pose.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kPolycamDepthScale = 1000.0;  // millimetres

// Confidence is written as 0, 127 or 255; this is the least value of low, medium and high.
constexpr std::array kLeastConfidence = {0, 1, 192};

/// Twelve keys, t_00 to t_23, row by row; ARKit's axes.
Result<Pose> polycam_pose(const nlohmann::json& json) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const std::string key = "t_" + std::to_string(row) + std::to_string(column);
      const auto number = json_number(json, key.c_str());
      if (!number) return Error{ErrorCode::kInput, key + ": expected a number"};
      matrix(row, column) = *number;
    }
  }
  return pose_from_opengl(matrix);
}

/// That of the picture of colour.
std::optional<CameraIntrinsics> polycam_camera(const nlohmann::json& json) {
  const auto width = json_side(json, "width"), height = json_side(json, "height");
  if (!width || !height) return std::nullopt;
  CameraIntrinsics camera{*width, *height};
  const std::array<std::pair<const char*, double*>, 4> keys = {
      {{"fx", &camera.fx}, {"fy", &camera.fy}, {"cx", &camera.cx}, {"cy", &camera.cy}}};
  for (const auto& [key, value] : keys) *value = json_number(json, key).value_or(NAN);
  return camera.is_valid() ? std::optional(camera) : std::nullopt;
}

void read_polycam_camera(const fs::path& path, const Limits& limits, FrameEntry& entry) {
  if (path.empty()) {
    entry.fault = make_drop(DropReason::kNoPose, "the frame has no camera file", entry.depth);
    return;
  }
  const auto json = read_json_object(path, limits);
  if (!json) {
    entry.fault = Drop{DropReason::kUnreadable, json.error()};
    return;
  }
  const auto pose = polycam_pose(*json);
  entry.T_world_camera = pose ? pose : Result<Pose>(located(pose.error(), path));
  entry.camera = polycam_camera(*json);
  if (!entry.camera) {
    entry.fault = make_drop(DropReason::kNoIntrinsics, "expected width, height, fx, fy, cx and cy", path);
  }
}

OrDrop<DecodedFrame> decode_polycam_frame(const FrameEntry& entry, DecodeSettings settings) {
  const auto last = static_cast<int>(kLeastConfidence.size()) - 1;
  settings.min_confidence = kLeastConfidence[static_cast<std::size_t>(std::clamp(settings.min_confidence, 0, last))];
  return decode_png_frame_of_one_lens(entry, settings);
}

}  // namespace

bool fits_polycam(const Folder& folder, const Limits& limits) {
  const auto has = [&](const char* name, const char* suffix) {
    const auto files = numbered_files_below(folder, name, "", {suffix}, limits);
    return files && !files->empty();
  };
  return has("depth", ".png") && (has("corrected_cameras", ".json") || has("cameras", ".json"));
}

Result<Recording> index_polycam(const Folder& folder, const AcquireConfig& config) {
  const auto list = [&](const std::string& name, std::initializer_list<std::string_view> suffixes) {
    return numbered_files_below(folder, name.c_str(), "", suffixes, config.limits);
  };
  const auto depth = list("depth", {".png"});
  if (!depth) return depth.error();
  const auto confidence = list("confidence", {".png"});
  if (!confidence) return confidence.error();
  // The corrected cameras are in one world, the others drift in another: they are not mixed.
  auto cameras = list("corrected_cameras", {".json"});
  if (!cameras) return cameras.error();
  const bool is_corrected = !cameras->empty();
  if (!is_corrected) cameras = list("cameras", {".json"});
  if (!cameras) return cameras.error();
  const auto colour = list(is_corrected ? "corrected_images" : "images", {".jpg", ".jpeg", ".png"});
  if (!colour) return colour.error();

  Recording recording{.format = "polycam", .folder = folder.path, .depth_scale = kPolycamDepthScale};
  recording.frames_bring_camera = true;
  recording.world_up = UpAxis::kY;  // ARKit's worlds stand upright
  recording.decode = decode_polycam_frame;
  for (const auto& [number, path] : *depth) {
    FrameEntry entry{.sequence = recording.entries.size(), .depth = path};
    constexpr std::uint64_t kMost_us = 9'000'000'000'000'000;  // 2^63 ns is 9.22e15 us
    if (number <= kMost_us) entry.timestamp_ns = static_cast<std::int64_t>(number) * 1000;
    entry.colour = file_of(*colour, number);
    entry.confidence = file_of(*confidence, number);
    read_polycam_camera(file_of(*cameras, number), config.limits, entry);
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

}  // namespace scanknit
