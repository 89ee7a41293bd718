#include "scan/silhouettes/turned_views.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/rotation.h"
#include "scan/refine/angle_file.h"

namespace scanknit {
namespace {

/// Degrees of each view.
Result<std::vector<double>> angles_of(const ScanJob& job, const SilhouettePictures& read) {
  const TurntableConfig& known = job.config.turntable;
  std::vector<double> angles;
  if (job.angles) {
    const auto file = read_angle_file(*job.angles);
    if (!file) return file.error();
    for (const std::size_t number : read.numbers) {
      if (number >= file->size()) {
        return Error{ErrorCode::kConfig,
                     "has " + std::to_string(file->size()) + " angles, but there are " +
                         std::to_string(read.frames.read) + " pictures",
                     job.angles->string()};
      }
      angles.push_back((*file)[number]);
    }
    return angles;
  }
  if (known.rpm > 0) {
    return Error{
        ErrorCode::kUsage,
        "turntable.rpm needs the time of each picture, which these do not have: set turntable.step, or give an "
        "angle file"};
  }
  const double step = known.step_degrees > 0 ? known.step_degrees : 360.0 / static_cast<double>(read.frames.read);
  for (const std::size_t number : read.numbers) angles.push_back(step * static_cast<double>(number));
  return angles;
}

/// The angles are those that were given: silhouettes are not asked for them.
TurntableResult described_table(const ScanJob& job, const SilhouetteAxis& axis,
                                const std::vector<TurnedSilhouette>& pictures, const SilhouettePictures& read) {
  TurntableResult table;
  table.is_refined = true;
  table.prior = job.angles ? AngleSource::kFile : AngleSource::kStep;
  table.angle_sigma_rad = std::numeric_limits<double>::infinity();
  table.axis_point = axis.point;
  table.rms_m = axis.off_px * axis.point.z() / read.views.front().camera.fx;
  table.key_frames = pictures.size();
  const double upwards = axis.direction.y() > 0 ? -1 : 1;
  table.axis_direction = upwards * axis.direction;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    table.angles_rad.emplace_back(read.numbers[i], upwards * pictures[i].angle_rad);
  }
  const auto [least, most] = std::minmax_element(
      pictures.begin(), pictures.end(), [](const auto& a, const auto& b) { return a.angle_rad < b.angle_rad; });
  table.turns = (most->angle_rad - least->angle_rad) / (2 * std::numbers::pi);
  return table;
}

}  // namespace

Result<TurnedViews> turn_views(const ScanJob& job, double distance_m, SilhouettePictures& read) {
  const auto degrees = angles_of(job, read);
  if (!degrees) return degrees.error();
  std::vector<TurnedSilhouette> pictures;
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    pictures.push_back({&read.views[i].silhouette, (*degrees)[i] * kDegree});
  }
  auto axis = find_silhouette_axis(pictures, read.views.front().camera, distance_m);
  if (!axis) return axis.error();
  const std::vector<Pose> poses = poses_round(*axis, pictures);
  for (std::size_t i = 0; i < poses.size(); ++i) read.views[i].T_world_camera = poses[i];
  return TurnedViews{*axis, described_table(job, *axis, pictures, read)};
}

}  // namespace scanknit
