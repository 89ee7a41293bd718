#include "scan/silhouettes/turned_views.h"

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

}  // namespace

Result<SilhouetteAxis> turn_views(const ScanJob& job, double distance_m, SilhouettePictures& read) {
  const auto degrees = angles_of(job, read);
  if (!degrees) return degrees.error();
  std::vector<TurnedSilhouette> pictures;
  for (std::size_t i = 0; i < read.views.size(); ++i) {
    pictures.push_back({&read.views[i].silhouette, (*degrees)[i] * kDegree});
  }
  auto axis = find_silhouette_axis(pictures, read.views.front().camera, distance_m);
  if (!axis) return axis;
  const std::vector<Pose> poses = poses_round(*axis, pictures);
  for (std::size_t i = 0; i < poses.size(); ++i) read.views[i].T_world_camera = poses[i];
  return axis;
}

}  // namespace scanknit
