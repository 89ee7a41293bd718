// Shapes whose measures are known, in metres.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/mesh.h"
#include "core/pose.h"
#include "tests/core/sample_meshes.h"

namespace scanknit::test {

inline Mesh scaled(Mesh mesh, const Eigen::Vector3f& factors) {
  for (Eigen::Vector3f& p : mesh.positions_m) p = p.cwiseProduct(factors);
  mesh.normals.clear();
  return mesh;
}

inline Mesh moved(Mesh mesh, const Pose& T_new_old) {
  for (Eigen::Vector3f& p : mesh.positions_m) p = (T_new_old * p.cast<double>()).cast<float>();
  mesh.normals.clear();
  return mesh;
}

inline Pose some_pose() {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(2.3, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(0.31, -0.12, 0.07);
  return pose;
}

inline Mesh box(double x_m, double y_m, double z_m) {
  return scaled(cube(), Eigen::Vector3d(x_m / 2, y_m / 2, z_m / 2).cast<float>());
}

inline Mesh ball(double radius_m) {
  return scaled(sphere(), Eigen::Vector3f::Constant(static_cast<float>(radius_m)));
}

/// A body of about 10 cm without any symmetry.
inline Mesh lump() {
  Mesh mesh = sphere();
  for (Eigen::Vector3f& p : mesh.positions_m) {
    const float stretch =
        1 + 0.35f * p.x() * p.x() * p.x() + 0.25f * p.x() * p.y() - 0.3f * p.y() * p.z() * p.z() + 0.15f * p.z();
    p = 0.04f * stretch * p.cwiseProduct(Eigen::Vector3f(1.3f, 1, 0.7f));
  }
  mesh.normals.clear();
  return mesh;
}

/// A square plate, centred, with a round hole through its middle along z, of `facets` flat facets.
inline Mesh plate_with_hole(double side_m, double thick_m, double hole_radius_m, std::uint32_t facets = 96) {
  Mesh mesh;
  for (const double z : {-thick_m / 2, thick_m / 2}) {
    for (std::uint32_t i = 0; i < facets; ++i) {
      const double angle = 2 * std::numbers::pi * i / facets;
      const Eigen::Vector2d way(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d rim = hole_radius_m * way;
      const Eigen::Vector2d border = side_m / 2 / way.cwiseAbs().maxCoeff() * way;
      mesh.positions_m.push_back(Eigen::Vector3d(rim.x(), rim.y(), z).cast<float>());
      mesh.positions_m.push_back(Eigen::Vector3d(border.x(), border.y(), z).cast<float>());
    }
  }
  const auto at = [facets](std::uint32_t layer, std::uint32_t i, std::uint32_t outer) {
    return 2 * (layer * facets + i % facets) + outer;
  };
  const auto add_quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t i = 0; i < facets; ++i) {
    add_quad(at(1, i, 0), at(1, i, 1), at(1, i + 1, 1), at(1, i + 1, 0));  // top
    add_quad(at(0, i, 0), at(0, i + 1, 0), at(0, i + 1, 1), at(0, i, 1));  // bottom
    add_quad(at(0, i, 1), at(0, i + 1, 1), at(1, i + 1, 1), at(1, i, 1));  // border
    add_quad(at(0, i, 0), at(1, i, 0), at(1, i + 1, 0), at(0, i + 1, 0));  // wall of the hole
  }
  return mesh;
}

/// An open square grid in z = 0 that faces +z, with a round dent amid it (a cosine bell, downwards).
inline Mesh sheet(double side_m, std::uint32_t cells, double dent_m = 0, double dent_radius_m = 0.02) {
  Mesh mesh;
  const auto place = [&](std::uint32_t i) { return side_m * (static_cast<double>(i) / cells - 0.5); };
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) {
      const double away = std::hypot(place(i), place(j)) / dent_radius_m;
      const double z = away < 1 ? -dent_m * (1 + std::cos(std::numbers::pi * away)) / 2 : 0;
      mesh.positions_m.push_back(Eigen::Vector3d(place(i), place(j), z).cast<float>());
    }
  }
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i, b = a + 1, c = b + cells + 1, d = c - 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

}  // namespace scanknit::test
