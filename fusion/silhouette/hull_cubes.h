// HullCubes: what silhouettes say of a whole cube of space.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "fusion/silhouette/silhouette.h"
#include "fusion/silhouette/visual_hull.h"

namespace scanknit {

/// Views that must see a point of the hull.
inline constexpr int kFewestSilhouettes = 2;

/// Cubes by their middle and half of their edge, in the world, metres.
class HullCubes {
 public:
  /// `views` outlive it.
  explicit HullCubes(std::span<const SilhouetteView> views);

  /// True if kFewestSilhouettes see the point; what fewer see is unknown, because one view alone bounds nothing.
  [[nodiscard]] bool is_seen(const Eigen::Vector3d& p) const;

  /// False if some view sees no part of the cube within its silhouette, but some outside of it.
  [[nodiscard]] bool may_hold_hull(const Eigen::Vector3d& middle, double half_m) const;

  /// False if the cube is no nearer than `band_m` to the hull's surface, as far as whole cubes tell.
  [[nodiscard]] bool may_hold_surface(const Eigen::Vector3d& middle, double half_m, double band_m) const;

 private:
  /// Where a view sees the ball round a cube; nothing if some of the ball is not before the camera.
  struct Outline {
    OutlineRect rect;
    double nearest_m, farthest_m;  ///< z-depth
  };
  [[nodiscard]] std::optional<Outline> outline_of(std::size_t i, const Eigen::Vector3d& middle, double half_m) const;

  /// Distances to the outline, metres; nothing unless the view sees the whole cube.
  struct Range {
    double least_m, greatest_m;
  };
  [[nodiscard]] std::optional<Range> range_of(std::size_t i, const Eigen::Vector3d& middle, double half_m) const;

  std::span<const SilhouetteView> views_;
  std::vector<Pose> T_camera_world_;
};

}  // namespace scanknit
