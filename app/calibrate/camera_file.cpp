#include "app/calibrate/camera_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace scanknit {
namespace {

/// Without a deviation: of a camera that was derived from the other.
std::string camera_text(const char* name, const CameraModel& model, const CameraModel* deviation) {
  const CameraIntrinsics& k = model.intrinsics;
  const auto line = [&](const char* key, double value, double CameraIntrinsics::*member) {
    const std::string sigma = deviation == nullptr ? "" : fmt::format("  # +- {:.2g}", deviation->intrinsics.*member);
    return fmt::format("  {}: {:.4f}{}\n", key, value, sigma);
  };
  std::string text = fmt::format("{}:\n  width: {}\n  height: {}\n", name, k.width, k.height);
  text += line("fx", k.fx, &CameraIntrinsics::fx) + line("fy", k.fy, &CameraIntrinsics::fy);
  text += line("cx", k.cx, &CameraIntrinsics::cx) + line("cy", k.cy, &CameraIntrinsics::cy);
  text += fmt::format("  distortion: [{:.6f}]", fmt::join(model.distortion, ", "));
  if (deviation != nullptr) text += fmt::format("  # k1 k2 p1 p2 k3 +- {:.2g}", fmt::join(deviation->distortion, " "));
  return text + "\n";
}

}  // namespace

std::string camera_file_text(const ScannerCameras& cameras, const CameraCalibration& calibration) {
  std::string text = fmt::format(
      "# Written by scanknit calibrate camera. For `run` and `capture`: --set acquire.intrinsics=THIS FILE\n"
      "# {} views, {} corners; {:.3f} pixels between seen and computed corners (root mean square).\n"
      "# Pixels; pixel centres are integers. +-: standard deviations.\n",
      calibration.views.size(), calibration.corners, calibration.error_px);
  const bool is_colour = cameras.colour.has_value();
  if (is_colour) text += camera_text("colour", *cameras.colour, &calibration.deviation);
  if (cameras.depth) text += camera_text("depth", *cameras.depth, is_colour ? nullptr : &calibration.deviation);
  return text;
}

}  // namespace scanknit
