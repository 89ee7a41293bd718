#include "fusion/turntable/look_through.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace scanknit {

void LookThrough::add_witness(DepthImage depth_m, const CameraIntrinsics& camera, double angle_rad) {
  witnesses_.push_back({std::move(depth_m), camera, angle_rad});
}

LookThrough::Evidence LookThrough::evidence_of(const Witness& witness, const Eigen::Vector3d& p_witness) const {
  constexpr double kMargin_m = 0.006;  // an axis and angles that are a little wrong
  constexpr double kSigmas = 4;
  if (!(p_witness.z() > 0)) return Evidence::kNothing;
  const Eigen::Vector2d pixel = witness.camera.project(p_witness);
  const auto x = static_cast<int>(std::lround(std::clamp(pixel.x(), -1e6, 1e6)));
  const auto y = static_cast<int>(std::lround(std::clamp(pixel.y(), -1e6, 1e6)));
  if (!witness.depth_m.contains(x - 1, y - 1) || !witness.depth_m.contains(x + 1, y + 1)) return Evidence::kNothing;
  const double margin_m = kMargin_m + kSigmas * noise_.sigma_m(p_witness.z());
  // Round a rim a pixel more or less must not decide.
  bool is_through = true;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      const double z = static_cast<double>(witness.depth_m.at(u, v));
      if (z > 0 && std::abs(z - p_witness.z()) <= margin_m) return Evidence::kThere;
      is_through = is_through && z > p_witness.z();
    }
  }
  return is_through ? Evidence::kNotThere : Evidence::kNothing;
}

std::size_t LookThrough::remove_from(DepthImage& depth_m, const CameraIntrinsics& camera, double angle_rad) const {
  std::vector<Pose> T_witness_camera;
  for (const Witness& witness : witnesses_) {
    T_witness_camera.push_back(turn_about(axis_, angle_rad - witness.angle_rad));
  }
  constexpr int kFewest = 2;  // one alone may be wrong
  std::vector<std::size_t> removed(static_cast<std::size_t>(depth_m.height()));
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      float& z = depth_m.at(x, y);
      if (!(z > 0)) continue;
      const Eigen::Vector3d p = camera.unproject(x, y, static_cast<double>(z));
      int there = 0;
      int not_there = 0;
      for (std::size_t i = 0; i < witnesses_.size(); ++i) {
        const Evidence evidence = evidence_of(witnesses_[i], T_witness_camera[i] * p);
        there += evidence == Evidence::kThere;
        not_there += evidence == Evidence::kNotThere;
      }
      if (not_there < kFewest || not_there <= there) continue;
      z = 0;
      ++removed[static_cast<std::size_t>(y)];
    }
  });
  std::size_t total = 0;
  for (const std::size_t row : removed) total += row;
  return total;
}

}  // namespace scanknit
