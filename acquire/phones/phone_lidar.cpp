// Phone LiDAR export: depth_NNNNN.png, conf_NNNNN.png, frame_NNNNN.jpg, frame_NNNNN.json (ARKit's camera and pose).
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "acquire/parse/json_numbers.h"
#include "acquire/parse/opengl_pose.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/numbered_name.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kPhoneDepthScale = 1000.0;  // millimetres

// The export states its intrinsics for the full sensor picture, whose size it leaves out: ARKit's is 1920 wide. Depth
// (256) and pictures (960) are that picture scaled.
constexpr double kSensorWidth = 1920;
constexpr double kSensorHeight = 1440;

Result<Pose> arkit_pose(const nlohmann::json& json, const fs::path& path) {
  const auto numbers = json_numbers(json, "cameraPoseARFrame", 16);
  if (!numbers) return Error{ErrorCode::kInput, "cameraPoseARFrame: expected sixteen numbers", path.string()};
  const auto arkit = pose_from_numbers(*numbers);
  if (!arkit) return located(arkit.error(), path);
  return pose_from_opengl(arkit->matrix());
}

// Fills in what frame_NNNNN.json says: camera, pose, time.
void read_frame_json(const fs::path& path, const Limits& limits, FrameEntry& entry) {
  const auto json = read_json_object(path, limits);
  if (!json) {
    entry.fault = Drop{DropReason::kUnreadable, json.error()};
    return;
  }
  if (json->contains("cameraPoseARFrame")) entry.T_world_camera = arkit_pose(*json, path);
  if (const auto k = json_numbers(*json, "intrinsics", 9)) {
    const CameraIntrinsics sensor{
        static_cast<int>(kSensorWidth), static_cast<int>(kSensorHeight), (*k)[0], (*k)[4], (*k)[2], (*k)[5]};
    if (sensor.is_valid()) entry.camera = sensor;
  }
  constexpr double kMaxSeconds = 9.0e9;  // 2^63 ns is 9.22e9 s
  const auto seconds = json_number(*json, "time");
  if (seconds && std::abs(*seconds) <= kMaxSeconds) entry.timestamp_ns = std::llround(*seconds * 1e9);
}

// The sensor's camera for a picture of this size: everything times width / 1920, as the export's makers do.
CameraIntrinsics scaled(const CameraIntrinsics& sensor, int width, int height) {
  const double sx = width / kSensorWidth;
  const double sy = height / kSensorHeight;
  return {width, height, sensor.fx * sx, sensor.fy * sy, sensor.cx * sx, sensor.cy * sy};
}

OrDrop<DecodedFrame> decode_phone_frame(const FrameEntry& entry, const DecodeSettings& settings) {
  auto decoded = decode_png_frame(entry, settings);
  auto* frame = std::get_if<DecodedFrame>(&decoded);
  if (frame == nullptr || !entry.camera) return decoded;
  frame->camera = scaled(*entry.camera, frame->depth_m.width(), frame->depth_m.height());
  frame->colour_camera = scaled(*entry.camera, frame->colour.width(), frame->colour.height());
  return decoded;
}

}  // namespace

bool fits_phone_lidar(const Folder& folder, const Limits&) {
  const auto any = [&](const char* prefix, const char* suffix) {
    return std::any_of(folder.files.begin(), folder.files.end(),
                       [&](const std::string& name) { return numbered_name(name, prefix, suffix).has_value(); });
  };
  return any("depth_", ".png") && any("frame_", ".json");
}

Result<Recording> index_phone_lidar(const Folder& folder, const AcquireConfig& config) {
  std::map<std::uint64_t, FrameEntry> frames;
  for (const std::string& name : folder.files) {
    const fs::path path = folder.path / name;
    if (const auto depth = numbered_name(name, "depth_", ".png")) {
      frames[*depth].depth = path;
    } else if (const auto confidence = numbered_name(name, "conf_", ".png")) {
      frames[*confidence].confidence = path;
    } else if (const auto colour = numbered_name(name, "frame_", ".jpg")) {
      frames[*colour].colour = path;
    } else if (const auto camera = numbered_name(name, "frame_", ".json")) {
      read_frame_json(path, config.limits, frames[*camera]);
    }
  }
  Recording recording{.format = "phone-lidar", .folder = folder.path, .depth_scale = kPhoneDepthScale};
  recording.frames_bring_camera = true;
  recording.world_up = UpAxis::kY;  // ARKit's worlds stand upright
  recording.decode = decode_phone_frame;
  for (auto& [number, entry] : frames) {
    entry.sequence = number;
    if (entry.depth.empty()) {
      const std::string digits = std::to_string(number);
      entry.depth =
          folder.path / ("depth_" + std::string(5 - std::min<std::size_t>(5, digits.size()), '0') + digits + ".png");
    }
    recording.entries.push_back(std::move(entry));
  }
  return recording;
}

}  // namespace scanknit
