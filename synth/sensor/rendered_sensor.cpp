#include "synth/sensor/rendered_sensor.h"

#include <array>
#include <cmath>

#include "synth/sensor/sensor_names.h"

namespace scanknit {
namespace {

RenderedSensor ideal() {
  return {};
}

RenderedSensor kinect1() {
  RenderedSensor sensor{.name = "kinect1", .units_per_metre = 5000};
  sensor.disparity = {.baseline_m = 0.075, .focal_px = 580, .noise_px = 0.06, .step_px = 1.0 / 8, .window_px = 7};
  sensor.range = {.min_m = 0.45, .max_m = 9.5};
  sensor.shadow = {.right_m = 0.050, .left_m = 0.025};  // depth is registered to the colour camera between both
  sensor.edges = {.reach_px = 1, .dropout = 0.25, .flying = 0.01, .lateral_px = 0.8};
  sensor.returns = {
      .reach_m = 10, .dark = 0.04, .gloss = 0.9, .patches = 0.3, .grazing_begin_deg = 65, .grazing_end_deg = 84};
  sensor.corners = {.share = 0.15, .radius_m = 0.02};
  sensor.bias = {.share = 0.015, .cells = 4};
  sensor.calibration = {.focal_share = 0.004, .centre_x_px = 2, .centre_y_px = -1.5};
  sensor.lens = {.k1 = 0.02, .k2 = -0.04};
  sensor.time = {.rate_hz = 30, .dropped = 0.01, .repeated = 0.005};
  sensor.shutter = {.depth_s = 0.030, .colour_s = 0.026};
  sensor.colour = {.delay_s = 0.010,
                   .jitter_s = 0.010,
                   .exposure_s = 0.012,
                   .adaptation = 0.8,
                   .white_balance = 0.5,
                   .noise = 0.012};
  return sensor;
}

RenderedSensor d435() {
  RenderedSensor sensor{.name = "d435", .width = 1280, .height = 720, .picture_focal_px = 909, .units_per_metre = 1000};
  sensor.disparity = {.baseline_m = 0.050, .focal_px = 640, .noise_px = 0.08, .step_px = 1.0 / 32, .window_px = 13};
  sensor.range = {.min_m = 0.28, .max_m = 65};
  sensor.shadow = {.right_m = 0.035, .left_m = 0.015};  // seen from the colour camera, between both
  sensor.edges = {.reach_px = 2, .dropout = 0.2, .flying = 0.02, .lateral_px = 2};
  sensor.returns = {
      .reach_m = 0, .dark = 0.02, .gloss = 0.7, .patches = 0.3, .grazing_begin_deg = 76, .grazing_end_deg = 88};
  sensor.corners = {.share = 0.15, .radius_m = 0.02};
  sensor.bias = {.share = 0.015, .cells = 3};
  sensor.calibration = {.focal_share = 0.002, .centre_x_px = 1.5, .centre_y_px = 1};
  sensor.lens = {.k1 = 0.005, .k2 = 0};
  sensor.time = {.rate_hz = 30, .dropped = 0.01, .repeated = 0.005};
  sensor.shutter = {.depth_s = 0, .colour_s = 0.015};  // the infrared pair has global shutters
  sensor.colour = {.delay_s = 0.008,
                   .jitter_s = 0.008,
                   .exposure_s = 0.010,
                   .adaptation = 0.8,
                   .white_balance = 0.5,
                   .noise = 0.010};
  return sensor;
}

RenderedSensor phone_lidar() {
  RenderedSensor sensor{
      .name = "phone_lidar", .width = 256, .height = 192, .picture_focal_px = 212, .units_per_metre = 1000};
  sensor.disparity = {.baseline_m = 0, .focal_px = 0, .noise_px = 0, .step_px = 0, .window_px = 13};
  sensor.ranging = {.floor_m = 0.0012, .share = 0.0005};
  sensor.range = {.min_m = 0.2, .max_m = 15};
  sensor.edges = {.reach_px = 3, .dropout = 0, .flying = 0.9, .lateral_px = 1.2};
  sensor.corners = {.share = 0.35, .radius_m = 0.06};
  sensor.bias = {.share = 0.01, .cells = 3};
  sensor.calibration = {.focal_share = 0.001, .centre_x_px = 0.2, .centre_y_px = 0.2};
  sensor.time = {.rate_hz = 30, .dropped = 0, .repeated = 0};
  sensor.shutter = {.depth_s = 0, .colour_s = 0.016};
  sensor.colour = {
      .delay_s = 0, .jitter_s = 0.004, .exposure_s = 0.012, .adaptation = 0.8, .white_balance = 0.6, .noise = 0.008};
  return sensor;
}

// In the order of kSensorNames.
constexpr std::array<RenderedSensor (*)(), kSensorNames.size()> kSensors = {ideal, kinect1, d435, phone_lidar};

}  // namespace

Result<RenderedSensor> make_sensor(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kSensors.size(); ++i) {
    if (name == kSensorNames[i]) return kSensors[i]();
    known += (known.empty() ? "" : ", ") + std::string(kSensorNames[i]);
  }
  return Error{ErrorCode::kConfig, "no such sensor; there are: " + known, std::string(name)};
}

CameraIntrinsics camera_of(const RenderedSensor& sensor, int width, int height) {
  const double shape = static_cast<double>(sensor.width) / sensor.height;
  if (width <= 0 && height <= 0) width = sensor.width;
  if (width <= 0) width = static_cast<int>(std::lround(height * shape));
  if (height <= 0) height = static_cast<int>(std::lround(width / shape));
  const double focal = sensor.picture_focal_px * width / sensor.width;
  return {width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0};
}

double picture_scale(const RenderedSensor& sensor, const CameraIntrinsics& camera) {
  return static_cast<double>(camera.width) / sensor.width;
}

CameraIntrinsics stated_camera(const RenderedSensor& sensor, const CameraIntrinsics& real) {
  const CalibrationModel& error = sensor.calibration;
  const double scale = picture_scale(sensor, real);
  CameraIntrinsics stated = real;
  stated.fx *= 1 + error.focal_share;
  stated.fy *= 1 + error.focal_share;
  stated.cx += scale * error.centre_x_px;
  stated.cy += scale * error.centre_y_px;
  return stated;
}

}  // namespace scanknit
