// AnalyticScene: a union of exact solids.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "synth/scene/scene.h"
#include "synth/scene/solid.h"

namespace scanknit {

/// The minimum of exact distances is the exact distance in free space. Inside matter, where solids overlap, it is only
/// a bound: nearest() then looks for the true foot on the solids' faces and on the seams between two solids. Solids
/// must overlap or be apart; where they only touch, the contact would count as surface.
class AnalyticScene final : public SyntheticScene {
 public:
  AnalyticScene(std::string name, CameraPath path, int default_frames, std::vector<Solid> solids);

  [[nodiscard]] std::optional<double> intersect(const Ray& ray, double max_t_m) const override;
  [[nodiscard]] double distance(const Eigen::Vector3d& p_world) const override;
  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p_world) const override;
  [[nodiscard]] Eigen::Vector3d colour(const SurfacePoint& point) const override;
  [[nodiscard]] SurfaceMaterial material(const SurfacePoint& point) const override;
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return bounds_; }

 private:
  struct NearestSolid {
    std::size_t index;
    FieldSample field;
  };
  [[nodiscard]] NearestSolid nearest_solid(const Eigen::Vector3d& p_world) const;
  [[nodiscard]] SurfacePoint nearest_from_inside(const Eigen::Vector3d& p_world, const NearestSolid& deepest) const;
  [[nodiscard]] std::optional<Eigen::Vector3d> nearest_on_seam(const Eigen::Vector3d& p_world, const Solid& a,
                                                               const Solid& b) const;
  [[nodiscard]] bool is_on_surface(const Eigen::Vector3d& p_world) const;

  std::vector<Solid> solids_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace scanknit
