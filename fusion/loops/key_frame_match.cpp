#include "fusion/loops/key_frame_match.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

// What two frames of the same place have in common, with other things in front of each other seen from either.
constexpr double kLeastOverlap = 0.3;
constexpr double kLeastInliers = 0.6;
constexpr double kLeastColour = 0.45;
constexpr double kMostContradicted = 0.2;

// Both ways must lead to the same place within this much, and this share of the depth.
constexpr double kAgree_m = 0.01;
constexpr double kAgreePerMetre = 0.01;
constexpr double kAgree_rad = 0.012;

// What stays of the noise when thousands of points are compared is not their noise but what they share: lenses,
// rounding of depth, edges. This share of a point's standard deviation.
constexpr double kSharedNoise = 0.3;

bool fits(const IcpResult& fit, Determined determined) {
  return (determined == Determined::kAny || fit.weak_directions == 0) && fit.overlap >= kLeastOverlap &&
         fit.inlier_share >= kLeastInliers && fit.colour_agreement >= kLeastColour &&
         fit.contradicted_share <= kMostContradicted;
}

IcpResult register_from_best(const KeyFrame& a, const KeyFrame& b, const std::vector<Pose>& guesses,
                             const IcpConfig& registration) {
  IcpConfig coarse = registration;
  coarse.last_level = coarse.first_level;
  IcpResult best;
  best.support = -1;
  for (const Pose& guess : guesses) {
    const IcpResult tried = register_frame(b.seen, a.seen, guess, coarse);
    if (tried.support > best.support) best = tried;
  }
  IcpConfig fine = registration;
  fine.first_level = coarse.last_level - 1;
  return register_frame(b.seen, a.seen, best.T_model_frame, fine);
}

}  // namespace

double expected_overlap(const KeyFrame& a, const KeyFrame& b, const Pose& T_a_b) {
  const SurfaceLevel& level = b.seen.levels.back();
  const CameraIntrinsics& view = a.seen.levels.back().intrinsics;
  std::size_t points = 0;
  std::size_t within = 0;
  for (int y = 0; y < level.intrinsics.height; ++y) {
    for (int x = 0; x < level.intrinsics.width; ++x) {
      const auto z_m = static_cast<double>(level.z_m[level.index(x, y)]);
      if (!(z_m > 0)) continue;
      ++points;
      const Eigen::Vector3d p = T_a_b * level.intrinsics.unproject(x, y, z_m);
      if (!(p.z() > 0.1)) continue;
      const double u = view.fx * p.x() / p.z() + view.cx;
      const double v = view.fy * p.y() / p.z() + view.cy;
      if (u >= 0 && v >= 0 && u <= view.width - 1 && v <= view.height - 1) ++within;
    }
  }
  return points > 0 ? static_cast<double>(within) / static_cast<double>(points) : 0;
}

std::optional<KeyFrameMatch> match_key_frames(const KeyFrame& a, const KeyFrame& b,
                                              const std::vector<Pose>& T_a_b_guesses, const IcpConfig& registration,
                                              Determined determined) {
  IcpConfig of_two = registration;
  of_two.noise = registration.noise.scaled(std::sqrt(2.0));  // both frames are noisy
  const IcpResult there = register_from_best(a, b, T_a_b_guesses, of_two);
  if (!fits(there, determined)) return std::nullopt;
  const IcpResult back = register_frame(a.seen, b.seen, there.T_model_frame.inverse(), of_two);
  if (!fits(back, determined)) return std::nullopt;
  const Pose apart = there.T_model_frame * back.T_model_frame;
  if (apart.translation().norm() > kAgree_m + kAgreePerMetre * b.depth_m) return std::nullopt;
  if (Eigen::AngleAxisd(apart.linear()).angle() > kAgree_rad) return std::nullopt;

  KeyFrameMatch match;
  match.T_a_b = interpolate(there.T_model_frame, back.T_model_frame.inverse(), 0.5);
  const double sigma_m = kSharedNoise * of_two.noise.sigma_m(b.depth_m);
  match.information = there.shape / (sigma_m * sigma_m);
  match.overlap = std::min(there.overlap, back.overlap);
  match.inlier_share = std::min(there.inlier_share, back.inlier_share);
  match.contradicted_share = std::max(there.contradicted_share, back.contradicted_share);
  match.colour_agreement = std::min(there.colour_agreement, back.colour_agreement);
  return match;
}

}  // namespace scanknit
