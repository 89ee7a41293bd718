// RenderedSensor: what a real depth sensor does to the pictures of a scene, as plain values.
#pragma once

#include <string>
#include <string_view>

#include "core/camera.h"
#include "core/result.h"
#include "synth/view_camera.h"

namespace scanknit {

// Default-constructed, every effect is off. Units, ranges and meaning of each value: sensor_keys.cpp; sources of the
// named sensors' values: docs/synthetic_scanner.md. "px" are pixels of the sensor's own picture, whatever the size of
// the picture that is rendered.

/// Depth from matching: disparity = baseline * focal / z. Off without a baseline.
struct DisparityModel {
  double baseline_m = 0, focal_px = 0;
  double noise_px = 0, step_px = 0, window_px = 1;
};

/// Noise that is not one of disparity: sqrt(floor^2 + (share z)^2).
struct RangingModel {
  double floor_m = 0, share = 0;
};

struct RangeModel {
  double min_m = 0, max_m = 100;
};

/// How far the centres that must see a point as well lie from the picture's own: the projector or second camera at its
/// right, and, where depth is registered to a colour camera, the camera that measures it at its left.
struct ShadowModel {
  double right_m = 0, left_m = 0;
};

/// Pixels beside a depth step.
struct EdgeModel {
  double reach_px = 1;
  double dropout = 0, flying = 0, lateral_px = 0;
};

/// Surfaces that send too little light back.
struct ReturnModel {
  double reach_m = 0;  ///< at which a white surface is just seen; 0: any distance
  double dark = 0, gloss = 0, patches = 0;
  double grazing_begin_deg = 90, grazing_end_deg = 90;
};

/// Concave corners are smeared.
struct CornerModel {
  double share = 0, radius_m = 0.03;
};

/// A smooth error of depth that belongs to the unit: dz / z = share * z / 4 m * field, the field from -1 to 1.
struct BiasModel {
  double share = 0, cells = 4;
};

/// How the camera that the sensor states differs from the one that it has.
struct CalibrationModel {
  double focal_share = 0, centre_x_px = 0, centre_y_px = 0;
};

struct TimeModel {
  double rate_hz = 30;
  double dropped = 0, repeated = 0;
};

/// From the first row to the last.
struct ShutterModel {
  double depth_s = 0, colour_s = 0;
};

struct ColourModel {
  double delay_s = 0, jitter_s = 0;
  double exposure_s = 0;
  double adaptation = 0, white_balance = 0, noise = 0;
};

struct RenderedSensor {
  std::string name = "ideal";
  int width = 640, height = 480;  ///< of the sensor's own picture
  double picture_focal_px = 525;  ///< of that picture: depth may be registered to a colour camera
  double units_per_metre = 10'000;
  DisparityModel disparity = {};
  RangingModel ranging = {};
  RangeModel range = {};
  ShadowModel shadow = {};
  EdgeModel edges = {};
  ReturnModel returns = {};
  CornerModel corners = {};
  BiasModel bias = {};
  CalibrationModel calibration = {};
  RadialLens lens = {};
  TimeModel time = {};
  ShutterModel shutter = {};
  ColourModel colour = {};
};

/// One of kSensorNames. Error kConfig: there is no such sensor; the message lists all.
[[nodiscard]] Result<RenderedSensor> make_sensor(std::string_view name);

/// The sensor's own camera; with a width or height above 0 the same field of view at another size. A missing one of the
/// two follows from the sensor's shape.
[[nodiscard]] CameraIntrinsics camera_of(const RenderedSensor& sensor, int width, int height);

/// What the sensor says that its camera is.
[[nodiscard]] CameraIntrinsics stated_camera(const RenderedSensor& sensor, const CameraIntrinsics& real);

/// Pixels of the rendered picture per pixel of the sensor's own.
[[nodiscard]] double picture_scale(const RenderedSensor& sensor, const CameraIntrinsics& camera);

}  // namespace scanknit
