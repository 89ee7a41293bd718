#include "acquire/parse/transforms_json.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acquire/parse/opengl_pose.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::array kLensModels = {"OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "RADIAL",
                                    "SIMPLE_RADIAL"};  // COLMAP's names

}  // namespace

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

Pose AppliedChange::undone(Pose T_file_camera) const {
  T_file_camera.translation() /= scale;
  return T_file_world.inverse() * T_file_camera;
}

UpAxis AppliedChange::world_up() const {
  constexpr std::array kUp = {UpAxis::kX, UpAxis::kY, UpAxis::kZ};
  constexpr std::array kDown = {UpAxis::kMinusX, UpAxis::kMinusY, UpAxis::kMinusZ};
  const Eigen::Vector3d up = T_file_world.linear().transpose() * Eigen::Vector3d::UnitZ();
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  return (up[axis] > 0 ? kUp : kDown)[static_cast<std::size_t>(axis)];
}

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

std::optional<Result<Pose>> pose_of(const Json& frame, const AppliedChange& change, const fs::path& path) {
  if (!frame.contains("transform_matrix")) return std::nullopt;
  const auto matrix = matrix_of(frame["transform_matrix"]);
  const auto pose = matrix ? pose_from_opengl(*matrix)
                           : Result<Pose>(Error{ErrorCode::kInput, "transform_matrix: expected 4 rows of 4 numbers"});
  if (!pose) return located(pose.error(), path);
  const Pose undone = change.undone(*pose);
  const auto checked = pose_from_matrix(undone.matrix());
  if (!checked) return Error{ErrorCode::kInput, "without applied_scale " + checked.error().message, path.string()};
  return undone;
}

Result<CameraModel> camera_of(const Json& frame, const Json& all) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kInput, what}; };
  const auto number = [&](const char* key) { return find_number(frame, all, key); };
  const Json* model = find_key(frame, all, "camera_model");
  const Json* is_fisheye = find_key(frame, all, "is_fisheye");
  const std::string name = model != nullptr && model->is_string() ? model->get<std::string>() : kLensModels[0];
  if (std::find(kLensModels.begin(), kLensModels.end(), name) == kLensModels.end()) {
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

}  // namespace scanknit
