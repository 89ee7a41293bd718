#include "app/calibrate/rig_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/rotation.h"

namespace scanknit {
namespace {

/// YAML takes JSON's strings.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string lens_text(const char* name, const CameraModel& model) {
  const CameraIntrinsics& k = model.intrinsics;
  return fmt::format(
      "      {}: {{width: {}, height: {}, fx: {:.4f}, fy: {:.4f}, cx: {:.4f}, cy: {:.4f}, distortion: [{:.6f}]}}\n",
      name, k.width, k.height, k.fx, k.fy, k.cx, k.cy, fmt::join(model.distortion, ", "));
}

std::string entry_text(const FoundCamera& found, const RigEntry& entry) {
  const Eigen::Vector3d& t = entry.T_rig_camera.translation();
  const Eigen::Quaterniond q(entry.T_rig_camera.linear());
  std::string text = fmt::format(
      "  - recording: {}  # {} moments that others see, too; {:.3f} pixels\n"
      "    T_rig_camera: [{:.6f}, {:.6f}, {:.6f}, {:.7f}, {:.7f}, {:.7f}, {:.7f}]  # +- {:.2g} mm, {:.2g} degrees\n"
      "    clock_offset_ms: {:.3f}  # +- {:.2g}\n",
      quoted(entry.recording), found.shared_moments, found.error_px, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w(),
      1000 * found.position_deviation_m, found.turn_deviation_rad / kDegree, 1000 * found.clock_offset_s,
      1000 * found.clock_deviation_s);
  if (!entry.camera.colour && !entry.camera.depth) {
    return text + fmt::format("    camera: {}\n", quoted(entry.camera_file.string()));
  }
  text += "    camera:\n";
  if (entry.camera.colour) text += lens_text("colour", *entry.camera.colour);
  if (entry.camera.depth) text += lens_text("depth", *entry.camera.depth);
  return text;
}

}  // namespace

std::string rig_text(const RigCalibration& found, const std::vector<RigEntry>& entries) {
  std::string text = fmt::format(
      "# Written by scanknit calibrate rig. {} moments at which two cameras or more see the board; {:.3f} pixels\n"
      "# between seen and computed corners (root mean square). T_rig_camera: tx ty tz qx qy qz qw, metres:\n"
      "# p_rig = T_rig_camera * p_camera, of depth's camera.\n"
      "# The rig's time is the camera's and clock_offset_ms. +-: standard deviations.\n"
      "cameras:\n",
      found.moments, found.error_px);
  for (std::size_t i = 0; i < entries.size(); ++i) text += entry_text(found.cameras[i], entries[i]);
  return text;
}

}  // namespace scanknit
