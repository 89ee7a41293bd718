#include "acquire/mkv/azure_calibration.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "acquire/parse/json_numbers.h"

namespace scanknit {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kParameters = 14;

std::string text_of(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

const Json* object_at(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_object() ? &*found : nullptr;
}

bool are_finite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
}

/// `Rt`: from the device's frame, which is depth's, to the camera's, in metres.
std::optional<Pose> pose_of(const Json& camera) {
  const Json* rt = object_at(camera, "Rt");
  if (rt == nullptr) return std::nullopt;
  const auto rotation = json_numbers(*rt, "Rotation", 9);
  const auto translation = json_numbers(*rt, "Translation", 3);
  if (!rotation || !translation || !are_finite(*rotation) || !are_finite(*translation)) return std::nullopt;
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> stated(rotation->data());
  constexpr double kAlmost = 1e-3;  // they are written as 32-bit floats
  const Eigen::Matrix3d matrix = stated;
  const bool is_rotation = (matrix * matrix.transpose()).isIdentity(kAlmost) && matrix.determinant() > 0;
  if (!is_rotation) return std::nullopt;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(translation->data());
  return pose;
}

/// ModelParameters: cx cy fx fy, k1 to k6, codx cody (the middle of the distortion), p2 p1.
Result<AzureCamera> camera_of(const Json& json) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kInput, what}; };
  const Json* intrinsics = object_at(json, "Intrinsics");
  const auto p = intrinsics == nullptr ? std::nullopt : json_numbers(*intrinsics, "ModelParameters", kParameters);
  if (!p || !are_finite(*p)) return refuse("expected 14 numbers as ModelParameters");
  const std::string model = text_of(*intrinsics, "ModelType");
  if (!model.ends_with("BrownConrady")) return refuse("its lens model '" + model.substr(0, 80) + "' is not known");
  if ((*p)[10] != 0 || (*p)[11] != 0) return refuse("the middle of its distortion is not its principal point");
  const auto width = json_side(json, "SensorWidth");
  const auto height = json_side(json, "SensorHeight");
  if (!width || !height) return refuse("SensorWidth or SensorHeight is missing");
  if ((*p)[2] <= 0 || (*p)[3] <= 0) return refuse("a focal length is not above 0");
  const auto pose = pose_of(json);
  if (!pose) return refuse("its place (Rt) is missing, or is no rotation and translation");
  AzureCamera camera;
  camera.cx = (*p)[0];
  camera.cy = (*p)[1];
  camera.fx = (*p)[2];
  camera.fy = (*p)[3];
  camera.distortion = {(*p)[4], (*p)[5], (*p)[13], (*p)[12], (*p)[6], (*p)[7], (*p)[8], (*p)[9]};
  camera.sensor_width = *width;
  camera.sensor_height = *height;
  camera.T_camera_device = *pose;
  return camera;
}

Result<AzureCamera> find_camera(const Json& cameras, const char* location) {
  for (const Json& camera : cameras) {
    if (camera.is_object() && text_of(camera, "Location") == location) return camera_of(camera);
  }
  return Error{ErrorCode::kInput, std::string("no camera ") + location + " is in it"};
}

/// A part of the full picture scaled to `full_width` x `full_height`, whose first pixel is at (left, top).
CameraIntrinsics part_of(const AzureCamera& camera, double full_width, double full_height, double left, double top,
                         int width, int height) {
  constexpr double kHalf = 0.5;  // the calibration counts from the corner of the first pixel, we from its middle
  return {width,
          height,
          camera.fx * full_width,
          camera.fy * full_height,
          camera.cx * full_width - left - kHalf,
          camera.cy * full_height - top - kHalf};
}

/// What a mode of depth takes of the sensor's 1024 x 1024 pixels, or of 512 x 512 when binned.
struct DepthMode {
  int width, height, full, left, top;
};
constexpr int kDepthSensor = 1024;
constexpr std::array kDepthModes = {DepthMode{320, 288, 512, 96, 90}, DepthMode{640, 576, 1024, 192, 180},
                                    DepthMode{512, 512, 512, 0, 0}, DepthMode{1024, 1024, 1024, 0, 0}};

}  // namespace

Result<AzureCalibration> parse_azure_calibration(std::span<const std::byte> text) {
  std::string letters;
  for (const std::byte byte : text) letters += std::to_integer<char>(byte);
  letters.erase(letters.find_last_not_of('\0') + 1);  // some recorders keep the zero at its end
  const Json json = Json::parse(letters, nullptr, false);
  const Json* information = json.is_object() ? object_at(json, "CalibrationInformation") : nullptr;
  const auto cameras = information == nullptr ? Json::const_iterator() : information->find("Cameras");
  if (information == nullptr || cameras == information->end() || !cameras->is_array()) {
    return Error{ErrorCode::kInput, "expected JSON with CalibrationInformation and its Cameras"};
  }
  return AzureCalibration{find_camera(*cameras, "CALIBRATION_CameraLocationD0"),
                          find_camera(*cameras, "CALIBRATION_CameraLocationPV0")};
}

Result<CameraIntrinsics> azure_depth_camera(const AzureCamera& camera, int width, int height) {
  if (camera.sensor_width == kDepthSensor && camera.sensor_height == kDepthSensor) {
    for (const DepthMode& mode : kDepthModes) {
      if (mode.width != width || mode.height != height) continue;
      return part_of(camera, mode.full, mode.full, mode.left, mode.top, width, height);
    }
  }
  if (camera.sensor_width == width && camera.sensor_height == height) {
    return part_of(camera, width, height, 0, 0, width, height);
  }
  return Error{ErrorCode::kInput, "pictures of " + std::to_string(width) + " x " + std::to_string(height) +
                                      " are no mode of its sensor of " + std::to_string(camera.sensor_width) + " x " +
                                      std::to_string(camera.sensor_height)};
}

CameraIntrinsics azure_colour_camera(const AzureCamera& camera, int width, int height) {
  const double full_height = static_cast<double>(width) * camera.sensor_height / camera.sensor_width;
  return part_of(camera, width, full_height, 0, (full_height - height) / 2, width, height);
}

}  // namespace scanknit
