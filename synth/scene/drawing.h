// Drawing: collects the solids of a scene, drawn on the plan (z up).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "synth/scene/analytic_scene.h"
#include "synth/scene/camera_paths.h"

namespace scanknit {

/// Objects are sunk so deep into what they stand on, because surfaces must not only touch.
inline constexpr double kSunk_m = 0.004;

/// A texture of pastel on dark, with a different hue for each index.
[[nodiscard]] Texture paint(int index, Pattern pattern, double period_m);

/// The texture of painted walls, with almost no features to track.
[[nodiscard]] Texture bare(int index);

/// A cone whose top is cut off.
[[nodiscard]] Lathe frustum(double bottom_radius, double top_radius, double height);

/// 22 cm high.
[[nodiscard]] Lathe vase();

class Drawing {
 public:
  void add(Shape shape, const Eigen::Vector3d& centre, const Texture& texture,
           const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity(), const SurfaceMaterial& material = {});
  /// A box that stands on `floor_m` at (x, y), turned about the vertical.
  void stand_box(double x, double y, double floor_m, const Eigen::Vector3d& size, const Texture& texture,
                 double turn_degrees = 0, double rounding_m = 0.004);
  void stand_cylinder(double x, double y, double floor_m, double radius, double height, const Texture& texture);
  /// A cylinder between two points; it reaches a little beyond both, so that rods that meet overlap.
  void add_rod(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_m, const Texture& texture);
  /// Its floor is at height 0.
  void add_room(const Eigen::Vector3d& size, const Texture& texture);
  /// The last solid is made of `material`.
  void made_of(const SurfaceMaterial& material) { solids_.back().set_material(material); }

  [[nodiscard]] std::unique_ptr<SyntheticScene> scene(std::string name, CameraPath path, int default_frames) &&;

  [[nodiscard]] static Eigen::Matrix3d yaw(double degrees);
  [[nodiscard]] static Eigen::Matrix3d roll(double degrees);

 private:
  std::vector<Solid> solids_;
};

}  // namespace scanknit
