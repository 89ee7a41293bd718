// transforms.json of nerfstudio (docs.nerf.studio, "Data conventions") and instant-ngp, with depth pictures: OpenGL's
// axes, a camera for each frame or one for all.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "acquire/layouts/opengl_pose.h"
#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/replay/undistort.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kFileName = "transforms.json";
constexpr std::array kDepthKeys = {"depth_file_path", "depth_path"};                  // nerfstudio, instant-ngp
constexpr std::array kUnitKeys = {"depth_unit_scale_factor", "integer_depth_scale"};  // nerfstudio, instant-ngp
constexpr std::array kModels = {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "RADIAL", "SIMPLE_RADIAL"};  // COLMAP's names
constexpr double kNerfstudioDepthScale = 1000.0;  // nerfstudio's default: 16-bit PNG in millimetres

// A frame's key, else that of all frames.
const Json* find_key(const Json& frame, const Json& all, const char* key) {
  if (const auto found = frame.find(key); found != frame.end()) return &*found;
  const auto found = all.find(key);
  return found == all.end() ? nullptr : &*found;
}

std::optional<double> find_number(const Json& frame, const Json& all, const char* key) {
  const Json* value = find_key(frame, all, key);
  return value != nullptr && value->is_number() ? std::optional(value->get<double>()) : std::nullopt;
}

std::string text_at(const Json& frame, const char* key) {
  const auto found = frame.find(key);
  return found != frame.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string depth_name(const Json& frame) {
  for (const char* key : kDepthKeys) {
    if (std::string name = text_at(frame, key); !name.empty()) return name;
  }
  return {};
}

Result<Json> read_transforms(const fs::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  Json json = Json::parse(*text, nullptr, false);
  const bool has_frames =
      json.is_object() && json.contains("frames") && json["frames"].is_array() &&
      std::all_of(json["frames"].begin(), json["frames"].end(), [](const Json& frame) { return frame.is_object(); });
  if (!has_frames) {
    return Error{ErrorCode::kInput, "not an object with a list of \"frames\", or truncated", path.string()};
  }
  return json;
}

/// 3 or 4 rows of four numbers.
std::optional<Eigen::Matrix4d> matrix_of(const Json& rows) {
  if (!rows.is_array() || rows.size() < 3 || rows.size() > 4) return std::nullopt;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (!rows[row].is_array() || rows[row].size() != 4) return std::nullopt;
    for (std::size_t column = 0; column < 4; ++column) {
      if (!rows[row][column].is_number()) return std::nullopt;
      matrix(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = rows[row][column].get<double>();
    }
  }
  return matrix;
}

/// What the file's writer did to the world: p_file = scale * T_file_world * p_world.
struct AppliedChange {
  Pose T_file_world = Pose::Identity();
  double scale = 1;

  [[nodiscard]] Pose undone(Pose T_file_camera) const {
    T_file_camera.translation() /= scale;
    return T_file_world.inverse() * T_file_camera;
  }

  /// z is up in the file; this is the axis of the world that comes nearest to it.
  [[nodiscard]] UpAxis world_up() const {
    constexpr std::array kUp = {UpAxis::kX, UpAxis::kY, UpAxis::kZ};
    constexpr std::array kDown = {UpAxis::kMinusX, UpAxis::kMinusY, UpAxis::kMinusZ};
    const Eigen::Vector3d up = T_file_world.linear().transpose() * Eigen::Vector3d::UnitZ();
    Eigen::Index axis = 0;
    up.cwiseAbs().maxCoeff(&axis);
    return (up[axis] > 0 ? kUp : kDown)[static_cast<std::size_t>(axis)];
  }
};

Result<AppliedChange> applied_change(const Json& json, const fs::path& path) {
  AppliedChange change;
  if (json.contains("applied_transform")) {
    const auto matrix = matrix_of(json["applied_transform"]);
    const auto pose = matrix ? pose_from_matrix(*matrix) : Error{ErrorCode::kInput, "expected 3 rows of 4 numbers"};
    if (!pose) return Error{ErrorCode::kInput, "applied_transform: " + pose.error().message, path.string()};
    change.T_file_world = *pose;
  }
  if (json.contains("applied_scale")) {
    change.scale = find_number(json, json, "applied_scale").value_or(0);
    if (!(change.scale > 0 && std::isfinite(change.scale))) {
      return Error{ErrorCode::kInput, "applied_scale: expected a number greater than 0", path.string()};
    }
  }
  return change;
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

/// A lens that a CameraModel can hold, of the picture of w x h pixels. The file counts pixels from the corner of the
/// first one, which is half a pixel before its centre.
Result<CameraModel> camera_of(const Json& frame, const Json& all) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kInput, what}; };
  const auto number = [&](const char* key) { return find_number(frame, all, key); };
  const Json* model = find_key(frame, all, "camera_model");
  const Json* is_fisheye = find_key(frame, all, "is_fisheye");
  const std::string name = model != nullptr && model->is_string() ? model->get<std::string>() : kModels[0];
  if (std::find(kModels.begin(), kModels.end(), name) == kModels.end()) {
    return refuse("camera_model: '" + name +
                  "' is not read, expected OPENCV, PINHOLE, SIMPLE_PINHOLE, RADIAL or "
                  "SIMPLE_RADIAL; undistort colour and depth to one of these first");
  }
  if ((is_fisheye != nullptr && *is_fisheye == Json(true)) || number("k4").value_or(0) != 0) {
    return refuse(
        "is_fisheye or k4: lenses of this kind are not read, expected k1 k2 k3 p1 p2 alone; undistort "
        "colour and depth first");
  }
  constexpr double kMaxSide = 1 << 20;
  const double w = number("w").value_or(0), h = number("h").value_or(0);
  if (!(w >= 1 && w <= kMaxSide && h >= 1 && h <= kMaxSide)) {
    return refuse("w, h: expected the size of the colour picture in pixels");
  }
  const auto focal = [&](const char* length, const char* angle, double side) -> double {
    if (const auto given = number(length)) return *given;
    const auto radians = number(angle);
    return radians ? side / (2 * std::tan(*radians / 2)) : 0;
  };
  CameraModel camera;
  CameraIntrinsics& k = camera.intrinsics;
  k = {static_cast<int>(w), static_cast<int>(h), focal("fl_x", "camera_angle_x", w),
       focal("fl_y", "camera_angle_y", h)};
  if (k.fy == 0) k.fy = k.fx;
  k.cx = number("cx").value_or(w / 2) - 0.5;
  k.cy = number("cy").value_or(h / 2) - 0.5;
  camera.distortion = {number("k1").value_or(0), number("k2").value_or(0), number("p1").value_or(0),
                       number("p2").value_or(0), number("k3").value_or(0)};
  const bool is_finite = std::all_of(camera.distortion.begin(), camera.distortion.end(),
                                     [](double coefficient) { return std::isfinite(coefficient); });
  if (!k.is_valid() || !is_finite) return refuse("fl_x, fl_y, cx, cy: expected finite numbers, fl_x not 0");
  return camera;
}

// The path of a picture, or the fault that drops its frame.
void place_picture(const Folder& folder, const std::string& name, fs::path FrameEntry::*member, FrameEntry& entry) {
  auto path = resolve_inside(folder.path, name);
  if (auto* drop = std::get_if<Drop>(&path)) {
    drop->error.where = (folder.path / kFileName).string();
    if (!entry.fault) entry.fault = std::move(*drop);
    return;
  }
  entry.*member = std::get<fs::path>(std::move(path));
  if (!(entry.*member).has_extension()) entry.*member += ".png";  // instant-ngp leaves it out
}

FrameEntry entry_of(const Json& frame, const Folder& folder, const AppliedChange& change) {
  FrameEntry entry;
  place_picture(folder, depth_name(frame), &FrameEntry::depth, entry);
  const std::string colour = text_at(frame, "file_path");
  if (!colour.empty()) place_picture(folder, colour, &FrameEntry::colour, entry);
  if (frame.contains("timestamp_ns") && frame["timestamp_ns"].is_number_integer()) {
    entry.timestamp_ns = frame["timestamp_ns"].get<std::int64_t>();
  }
  if (!frame.contains("transform_matrix")) return entry;
  const auto matrix = matrix_of(frame["transform_matrix"]);
  auto pose = matrix ? pose_from_opengl(*matrix)
                     : Result<Pose>(Error{ErrorCode::kInput, "transform_matrix: expected 4 rows of 4 numbers"});
  if (pose) pose = change.undone(*pose);
  entry.T_world_camera = pose ? pose : Result<Pose>(located(pose.error(), folder.path / kFileName));
  return entry;
}

using Cameras = std::shared_ptr<std::vector<CameraModel>>;

// Both pictures were taken by one lens; each has its own size.
OrDrop<DecodedFrame> decode_frame(const FrameEntry& entry, const DecodeSettings& settings, const Cameras& cameras) {
  auto decoded = decode_png_frame(entry, settings);
  auto* frame = std::get_if<DecodedFrame>(&decoded);
  if (frame == nullptr || cameras == nullptr) return decoded;
  const CameraModel& model = (*cameras)[entry.depth_index];
  const bool bends = model.distortion != Distortion{};
  frame->camera = model.intrinsics.resized(frame->depth_m.width(), frame->depth_m.height());
  if (bends) frame->depth_m = undistort(frame->depth_m, *frame->camera, model.distortion);
  if (frame->colour.empty()) return decoded;
  frame->colour_camera = model.intrinsics.resized(frame->colour.width(), frame->colour.height());
  if (!bends) return decoded;
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
  if (!folder.has_file(kFileName)) return false;
  const auto json = read_transforms(folder.path / kFileName, limits);
  return json && std::any_of((*json)["frames"].begin(), (*json)["frames"].end(),
                             [](const Json& frame) { return !depth_name(frame).empty(); });
}

Result<Recording> index_nerfstudio(const Folder& folder, const AcquireConfig& config) {
  const fs::path path = folder.path / kFileName;
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
  recording.decode = [cameras](const FrameEntry& entry, const DecodeSettings& settings) {
    return decode_frame(entry, settings, cameras);
  };
  return recording;
}

}  // namespace scanknit
