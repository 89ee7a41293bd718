// The cameras of an Azure Kinect, from the calibration that its recorder attaches to every recording.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "acquire/replay/undistort.h"
#include "core/camera.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// One camera as the device's memory has it: of the sensor's full picture, of which every mode is a part.
struct AzureCamera {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< parts of the full picture's width and height, from its corner
  RationalDistortion distortion{};
  int sensor_width = 0, sensor_height = 0;
  Pose T_camera_device = Pose::Identity();
};

struct AzureCalibration {
  Result<AzureCamera> depth, colour;  ///< an Error (kInput, without `where`) says why it is not known
};

/// Reads `CalibrationInformation`, which is JSON. Errors (kInput, without `where`): it is something else.
[[nodiscard]] Result<AzureCalibration> parse_azure_calibration(std::span<const std::byte> text);

/// The camera of depth pictures of this size: the narrow field of view (640 x 576, binned 320 x 288), the wide one
/// (1024 x 1024, binned 512 x 512), or the sensor's whole picture. Errors (kInput, without `where`): another size.
[[nodiscard]] Result<CameraIntrinsics> azure_depth_camera(const AzureCamera& camera, int width, int height);

/// The camera of colour pictures of this size, which are the full picture scaled to their width, with as much cut off
/// above as below.
[[nodiscard]] CameraIntrinsics azure_colour_camera(const AzureCamera& camera, int width, int height);

}  // namespace scanknit
