// transforms.json of nerfstudio (docs.nerf.studio, "Data conventions") and instant-ngp, with depth pictures: OpenGL's
// axes, a camera for each frame or one for all.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "acquire/parse/opengl_pose.h"
#include "acquire/parse/transforms_json.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/undistort.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::array kDepthKeys = {"depth_file_path", "depth_path"};                  // nerfstudio, instant-ngp
constexpr std::array kUnitKeys = {"depth_unit_scale_factor", "integer_depth_scale"};  // nerfstudio, instant-ngp
constexpr double kNerfstudioDepthScale = 1000.0;  // nerfstudio's default: 16-bit PNG in millimetres

std::string depth_name(const Json& frame) {
  for (const char* key : kDepthKeys) {
    if (std::string name = text_at(frame, key); !name.empty()) return name;
  }
  return {};
}

/// Raw units per metre.
Result<double> depth_scale(const Json& json, const fs::path& path) {
  for (const char* key : kUnitKeys) {
    if (!json.contains(key)) continue;
    const double scale = 1 / find_number(json, json, key).value_or(0);
    if (!(scale >= 1 && scale <= 1e7)) {
      return Error{ErrorCode::kInput, std::string(key) + ": expected metres of one raw unit, 1e-7 to 1", path.string()};
    }
    const double whole = std::round(scale);
    return std::abs(scale - whole) < 1e-9 * whole ? whole : scale;  // 0.0002 means 1/5000
  }
  return kNerfstudioDepthScale;
}

// The path of a picture, or the fault that drops its frame.
void place_picture(const Folder& folder, const std::string& name, SharedPath FrameEntry::*member, FrameEntry& entry) {
  auto path = resolve_inside(folder.path, name);
  if (auto* drop = std::get_if<Drop>(&path)) {
    drop->error.where = (folder.path / kTransformsFile).string();
    if (!entry.fault) entry.fault = std::move(*drop);
    return;
  }
  fs::path picture = std::get<fs::path>(std::move(path));
  if (!picture.has_extension()) picture += ".png";  // instant-ngp leaves it out
  entry.*member = std::move(picture);
}

FrameEntry entry_of(const Json& frame, const Folder& folder, const AppliedChange& change) {
  FrameEntry entry;
  place_picture(folder, depth_name(frame), &FrameEntry::depth, entry);
  const std::string colour = text_at(frame, "file_path");
  if (!colour.empty()) place_picture(folder, colour, &FrameEntry::colour, entry);
  if (frame.contains("timestamp_ns") && frame["timestamp_ns"].is_number_integer()) {
    entry.timestamp_ns = frame["timestamp_ns"].get<std::int64_t>();
  }
  entry.T_world_camera = pose_of(frame, change, folder.path / kTransformsFile);
  return entry;
}

using Cameras = std::shared_ptr<std::vector<CameraModel>>;

// Both pictures were taken by one lens; each has its own size.
// `states_colour`: the configuration states colour's lens.
OrDrop<DecodedFrame> decode_frame(const FrameEntry& entry, const DecodeSettings& settings, const Cameras& cameras,
                                  bool states_colour) {
  auto decoded = decode_png_frame(entry, settings);
  auto* frame = std::get_if<DecodedFrame>(&decoded);
  if (frame == nullptr || cameras == nullptr) return decoded;
  const CameraModel& model = (*cameras)[entry.depth_index];
  const bool bends = model.distortion != Distortion{};
  frame->camera = model.intrinsics.resized(frame->depth_m.width(), frame->depth_m.height());
  if (bends) frame->depth_m = undistort(frame->depth_m, *frame->camera, model.distortion);
  if (frame->colour.empty()) return decoded;
  frame->colour_camera = model.intrinsics.resized(frame->colour.width(), frame->colour.height());
  if (!bends || states_colour) return decoded;
  frame->colour = undistort(frame->colour, *frame->colour_camera, model.distortion);
  frame->encoded_colour = nullptr;
  return decoded;
}

// As nerfstudio sorts frames, whose order in the file is that of the program that found the poses.
std::vector<const Json*> frames_by_name(const Json& json) {
  std::vector<std::pair<std::string, const Json*>> named;
  for (const Json& frame : json["frames"]) {
    const std::string colour = text_at(frame, "file_path");
    const std::string depth = depth_name(frame);
    if (!depth.empty()) named.emplace_back(colour.empty() ? depth : colour, &frame);
  }
  std::stable_sort(named.begin(), named.end(),
                   [](const auto& a, const auto& b) { return natural_less(a.first, b.first); });
  std::vector<const Json*> frames;
  for (const auto& [name, frame] : named) frames.push_back(frame);
  return frames;
}

}  // namespace

bool fits_nerfstudio(const Folder& folder, const Limits& limits) {
  if (!folder.has_file(kTransformsFile)) return false;
  const auto json = read_transforms(folder.path / kTransformsFile, limits);
  return json && std::any_of((*json)["frames"].begin(), (*json)["frames"].end(),
                             [](const Json& frame) { return !depth_name(frame).empty(); });
}

Result<Recording> index_nerfstudio(const Folder& folder, const AcquireConfig& config) {
  const fs::path path = folder.path / kTransformsFile;
  const auto json = read_transforms(path, config.limits);
  if (!json) return json.error();
  const auto change = applied_change(*json, path);
  if (!change) return change.error();
  const auto scale = depth_scale(*json, path);
  if (!scale) return scale.error();
  Recording recording{.format = "nerfstudio", .folder = folder.path, .depth_scale = *scale};
  recording.world_up = change->world_up();
  const std::vector<const Json*> frames = frames_by_name(*json);
  if (const std::size_t flat = (*json)["frames"].size() - frames.size(); flat > 0) {
    recording.warnings.push_back(std::to_string(flat) + " frames name no depth picture and are left out");
  }
  // The camera of the configuration stands for all of these.
  const Cameras cameras = config.intrinsics ? nullptr : std::make_shared<std::vector<CameraModel>>();
  for (const Json* frame : frames) {
    FrameEntry entry = entry_of(*frame, folder, *change);
    entry.sequence = entry.depth_index = recording.entries.size();
    if (cameras != nullptr) {
      const auto camera = camera_of(*frame, *json);
      if (!camera && !entry.fault) entry.fault = make_drop(DropReason::kNoIntrinsics, camera.error().message, path);
      cameras->push_back(camera ? *camera : CameraModel{});
    }
    recording.entries.push_back(std::move(entry));
  }
  // One camera that cannot be held is that of all frames, where none can.
  const auto& entries = recording.entries;
  const bool is_none_held =
      !entries.empty() && std::all_of(entries.begin(), entries.end(), [](const FrameEntry& entry) {
        return entry.fault && entry.fault->reason == DropReason::kNoIntrinsics;
      });
  if (is_none_held) return entries.front().fault->error;
  recording.frames_bring_camera = cameras != nullptr;
  const bool states_colour = config.camera && config.camera->colour;
  recording.decode = [cameras, states_colour](const FrameEntry& entry, const DecodeSettings& settings) {
    return decode_frame(entry, settings, cameras, states_colour);
  };
  return recording;
}

}  // namespace scanknit
