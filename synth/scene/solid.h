// Solid: one exact primitive with a pose in the world.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "core/pose.h"
#include "synth/scene/scene.h"
#include "synth/scene/texture.h"

namespace scanknit {

struct Sphere {
  double radius_m;
};

/// `half_m` is half the side and includes the rounding of the edges.
struct Box {
  Eigen::Vector3d half_m;
  double rounding_m = 0;
};

/// About the z axis; the rims are rounded.
struct Cylinder {
  double radius_m;
  double half_height_m;
  double rounding_m = 0;
};

/// About the z axis.
struct Torus {
  double major_m;
  double minor_m;
};

/// A profile (radius, height), rotated about the z axis: a cone, a bottle. It goes upwards, from the axis to the axis.
struct Lathe {
  std::vector<Eigen::Vector2d> profile_m;
};

using Shape = std::variant<Sphere, Box, Cylinder, Torus, Lathe>;

/// The value of a distance field and its gradient, a unit vector.
struct FieldSample {
  double distance_m;
  Eigen::Vector3d gradient;
};

class Solid {
 public:
  Solid(Shape shape, const Pose& T_world_solid, const Texture& texture);

  /// A room: matter outside of a box, so that its faces are walls, floor and ceiling.
  [[nodiscard]] static Solid room(const Eigen::Vector3d& half_m, const Pose& T_world_solid, const Texture& texture);

  /// Exact on both sides of the surface.
  [[nodiscard]] FieldSample field(const Eigen::Vector3d& p_world) const;

  /// A cheap lower bound of field(p_world).distance_m.
  [[nodiscard]] double distance_bound(const Eigen::Vector3d& p_world) const {
    if (is_room_) return -std::numeric_limits<double>::infinity();
    return (p_world - T_world_solid_.translation()).norm() - bounding_radius_m_;
  }

  /// True only if the ray passes the solid's bounding sphere, or ends before it: a cheap test before intersect().
  [[nodiscard]] bool is_missed_by(const Ray& ray, double max_t_m) const {
    const Eigen::Vector3d to_centre = T_world_solid_.translation() - ray.origin;
    const double nearest_m = to_centre.dot(ray.direction);
    const double reach_m = bounding_radius_m_ + 1e-6;  // far above rounding: intersect() decides what is close
    if (nearest_m < -reach_m || nearest_m > max_t_m + reach_m) return !is_room_;
    return to_centre.squaredNorm() - nearest_m * nearest_m > reach_m * reach_m && !is_room_;
  }

  /// The distance along the ray, up to `max_t_m`, at which it first enters the solid.
  [[nodiscard]] std::optional<double> intersect(const Ray& ray, double max_t_m) const;

  [[nodiscard]] Eigen::Vector3d colour(const Eigen::Vector3d& p_world) const;
  [[nodiscard]] const SurfaceMaterial& material() const { return material_; }
  void set_material(const SurfaceMaterial& material) { material_ = material; }
  [[nodiscard]] Eigen::AlignedBox3d bounds() const;

 private:
  [[nodiscard]] std::optional<double> leave_room(const Ray& ray_solid) const;
  [[nodiscard]] std::optional<double> trace_convex(const Ray& ray_solid, double t_m, double t_end_m) const;
  [[nodiscard]] std::optional<double> trace_any(const Ray& ray_solid, double t_m, double t_end_m) const;

  Shape shape_;
  Pose T_world_solid_;
  Pose T_solid_world_;
  Texture texture_;
  SurfaceMaterial material_;
  double bounding_radius_m_;  // radius of a bounding sphere about the solid's origin
  bool is_convex_;
  bool is_room_ = false;
};

}  // namespace scanknit
