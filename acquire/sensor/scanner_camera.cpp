#include "acquire/sensor/scanner_camera.h"

#include <algorithm>
#include <cmath>

#include "acquire/sensor/depth_bias.h"

namespace scanknit {
namespace {

std::string sides_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

bool is_usable(const std::optional<CameraModel>& camera) {
  const auto is_finite = [](double k) { return std::isfinite(k); };
  return !camera || (camera->intrinsics.is_valid() &&
                     std::all_of(camera->distortion.begin(), camera->distortion.end(), is_finite));
}

}  // namespace

Result<void> check_cameras(const AcquireConfig& config) {
  if (!config.camera) return {};
  const auto refuse = [&](const char* what) { return Error{ErrorCode::kConfig, what, config.camera->file}; };
  if (config.camera->depth && config.intrinsics) {
    return refuse("acquire.camera and acquire.intrinsics both state the depth camera; give one of them");
  }
  if (!is_usable(config.camera->colour) || !is_usable(config.camera->depth)) {
    return refuse("acquire.camera: expected finite numbers, fx and fy not 0, width and height 1 or more");
  }
  if (config.camera->depth_bias && !is_valid(*config.camera->depth_bias)) {
    return refuse("acquire.camera: depth_bias: expected columns * rows numbers of each kind, within their bounds");
  }
  return {};
}

Result<void> refuse_other_cameras(const AcquireConfig& config, const std::string& who) {
  if (config.camera) {
    return Error{ErrorCode::kConfig, "acquire.camera: not for stereo pairs, whose two cameras are stated by " + who,
                 config.camera->file};
  }
  if (config.intrinsics) {
    return Error{ErrorCode::kConfig,
                 "acquire.intrinsics: not for stereo pairs, whose two cameras are stated by " + who};
  }
  return {};
}

Result<void> check_serial(const ScannerCamera& camera, const std::string& serial) {
  if (camera.serial.empty() || serial.empty() || camera.serial == serial) return {};
  return Error{ErrorCode::kConfig,
               "acquire.camera: this is the calibration of the scanner with serial number " + camera.serial +
                   ", not of that with " + serial + "; give that scanner's own file",
               camera.file};
}

Result<void> override_calibration(const ScannerCamera& camera, std::span<const StreamProfile> streams,
                                  RawCalibration& calibration) {
  if (auto fits = check_serial(camera, calibration.serial); !fits) return fits;
  for (const StreamProfile& stream : streams) {
    const bool is_depth = stream.kind == StreamKind::kDepth;
    const std::optional<CameraModel>& model = is_depth ? camera.depth : camera.colour;
    if (!model) continue;
    const CameraIntrinsics& k = model->intrinsics;
    if (k.width != stream.width || k.height != stream.height) {
      return Error{ErrorCode::kConfig,
                   std::string("acquire.camera: its ") + (is_depth ? "depth" : "colour") +
                       " camera is for pictures of " + sides_text(k.width, k.height) + ", but the scanner sends " +
                       sides_text(stream.width, stream.height) +
                       "; ask the scanner for that size, or calibrate it with this one",
                   camera.file};
    }
    (is_depth ? calibration.depth : calibration.colour) = *model;
  }
  if (camera.T_colour_depth) calibration.T_colour_depth = *camera.T_colour_depth;
  return {};
}

}  // namespace scanknit
