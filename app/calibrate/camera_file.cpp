#include "app/calibrate/camera_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <vector>

#include "core/rotation.h"

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

std::string numbers_text(const char* name, const std::vector<double>& numbers, int columns) {
  std::string text = fmt::format("  {}: [\n", name);
  const auto row = static_cast<std::size_t>(columns);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    text += fmt::format("{}{:.7f}{}", i % row == 0 ? "    " : " ", numbers[i], i + 1 == numbers.size() ? "]" : ",");
    if ((i + 1) % row == 0) text += "\n";
  }
  return text;
}

std::string bias_text(const DepthBias& bias, const DepthCalibration& measured) {
  std::string text =
      fmt::format("depth_bias:  # 1 / z = (1 + scale) / z_measured + shift; from {} views, {:.2f} to {:.2f} m\n",
                  measured.views, measured.nearest_m, measured.farthest_m);
  for (const DepthDeviation& at : measured.deviations) {
    text += fmt::format("  # +- {:.1f} mm at {:.0f} m\n", 1000 * at.deviation_m, at.distance_m);
  }
  return text + fmt::format("  columns: {}\n  rows: {}\n", bias.columns, bias.rows) +
         numbers_text("scale", bias.scale, bias.columns) + numbers_text("shift_per_m", bias.shift_per_m, bias.columns);
}

std::string pose_text(const Pose& T_colour_depth, const PoseVector& deviation) {
  const Eigen::Vector3d& t = T_colour_depth.translation();
  const Eigen::Quaterniond q(T_colour_depth.linear());
  return fmt::format(
      "T_colour_depth: [{:.6f}, {:.6f}, {:.6f}, {:.7f}, {:.7f}, {:.7f}, {:.7f}]  # +- {:.2g} mm, {:.2g} degrees\n",
      t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w(), 1000 * deviation.head<3>().norm(),
      deviation.tail<3>().norm() / kDegree);
}

}  // namespace

std::string camera_file_text(const ScannerCamera& cameras, const CameraCalibration& calibration,
                             const DepthCalibration* depth) {
  std::string text = fmt::format(
      "# Written by scanknit calibrate camera. For `run` and `capture`: --set acquire.camera=THIS FILE\n"
      "# {} views, {} corners; {:.3f} pixels between seen and computed corners (root mean square).\n"
      "# Pixels; pixel centres are integers. +-: standard deviations.\n",
      calibration.views.size(), calibration.corners, calibration.error_px);
  const bool is_colour = cameras.colour.has_value();
  if (is_colour) text += camera_text("colour", *cameras.colour, &calibration.deviation);
  if (cameras.depth) text += camera_text("depth", *cameras.depth, is_colour ? nullptr : &calibration.deviation);
  if (depth == nullptr) return text;
  if (cameras.T_colour_depth) text += pose_text(*cameras.T_colour_depth, depth->correction_deviation);
  if (cameras.colour_later_s) {
    text += fmt::format("time_offset_ms: {:.2f}  # +- {:.2g}\n", 1000 * *cameras.colour_later_s,
                        1000 * depth->colour_later_deviation_s);
  }
  if (cameras.depth_bias) text += bias_text(*cameras.depth_bias, *depth);
  return text;
}

}  // namespace scanknit
