// SightLines: the lines of sight of a range scanner without a known pinhole camera.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <optional>

namespace scanknit {

/// In a scan's own frame, metres.
///   kTwoSlits  every line crosses two lines that lie across z: one along y at (x of `centre`, z of its slit), one
///              along x. A slit at infinity makes the lines parallel along that axis. Parallel rays, a sheet of laser
///              light that is moved sideways, and a pinhole that looks along z are all of this kind.
///   kSphere    every line passes through `centre`.
struct SightLines {
  enum class Kind { kTwoSlits, kSphere };
  Kind kind = Kind::kSphere;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< kTwoSlits: z of the plane in which u and v are measured
  /// kTwoSlits: 1 / (z of the slit - z of the plane), for x and y; 0: parallel.
  Eigen::Vector2d slit_per_m = Eigen::Vector2d::Zero();
  double towards = 1;  ///< kTwoSlits: +1 if the scanner is at larger z than the surface, -1 if at smaller z
  int pole = 1;        ///< kSphere: the axis (0 x, 1 y, 2 z) about which u is the angle; few points should be near it

  /// A line (u, v) and a distance along it. u and v are in metres for kTwoSlits, in radians for kSphere; `range_m`
  /// increases away from the scanner.
  struct Sight {
    double u, v, range_m;
  };

  /// The line through a point; nothing if there is none (behind a slit, at the centre).
  [[nodiscard]] std::optional<Sight> look(const Eigen::Vector3d& p) const {
    if (kind == Kind::kSphere) return look_from_centre(p);
    const double depth = p.z() - centre.z();
    const double shrink_u = 1 - depth * slit_per_m.x();
    const double shrink_v = 1 - depth * slit_per_m.y();
    if (!(shrink_u > 1e-6) || !(shrink_v > 1e-6)) return std::nullopt;
    return Sight{centre.x() + (p.x() - centre.x()) / shrink_u, centre.y() + (p.y() - centre.y()) / shrink_v,
                 -towards * depth};
  }

  /// The unit direction away from the scanner, at a point that has a line.
  [[nodiscard]] Eigen::Vector3d direction(const Eigen::Vector3d& p) const {
    if (kind == Kind::kSphere) return (p - centre).normalized();
    const double depth = p.z() - centre.z();
    const double dx = -(p.x() - centre.x()) / (1 - depth * slit_per_m.x()) * slit_per_m.x();
    const double dy = -(p.y() - centre.y()) / (1 - depth * slit_per_m.y()) * slit_per_m.y();
    return (-towards * Eigen::Vector3d(dx, dy, 1)).normalized();
  }

  /// The period of u; 0: u is not periodic.
  [[nodiscard]] double period_u() const { return kind == Kind::kSphere ? 2 * std::numbers::pi : 0; }

 private:
  [[nodiscard]] std::optional<Sight> look_from_centre(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d d = p - centre;
    const double range = d.norm();
    if (!(range > 1e-9)) return std::nullopt;
    const double along = d[(pole + 1) % 3];
    const double across = d[(pole + 2) % 3];
    return Sight{std::atan2(across, along), std::asin(std::min(1.0, std::max(-1.0, d[pole] / range))), range};
  }
};

}  // namespace scanknit
