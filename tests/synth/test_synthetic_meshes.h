// Meshes with a known shape, for the tests of the synthetic scanner.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "core/mesh.h"

namespace scanknit::test {

/// A sphere from an icosahedron, each of whose triangles is split in four `levels` times. All vertices are on the
/// sphere; `centre` moves it.
inline Mesh icosphere(double radius_m, int levels, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  const double phi = (1 + std::sqrt(5.0)) / 2;
  std::vector<Eigen::Vector3d> points;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-phi, phi}) {
      points.emplace_back(0, a, b);
      points.emplace_back(a, b, 0);
      points.emplace_back(b, 0, a);
    }
  }
  for (Eigen::Vector3d& p : points) p.normalize();
  Mesh mesh;
  // The faces of an icosahedron: three corners whose mutual distance is its edge.
  const double edge = 2 / std::sqrt(1 + phi * phi) * 1.01;
  const auto near = [&](std::uint32_t i, std::uint32_t j) { return (points[i] - points[j]).norm() < edge; };
  for (std::uint32_t i = 0; i < 12; ++i) {
    for (std::uint32_t j = i + 1; j < 12; ++j) {
      for (std::uint32_t k = j + 1; k < 12; ++k) {
        if (!near(i, j) || !near(j, k) || !near(k, i)) continue;
        const bool outwards = points[i].dot(points[j].cross(points[k])) > 0;
        mesh.triangles.push_back(outwards ? Triangle{i, j, k} : Triangle{i, k, j});
      }
    }
  }
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return found->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b);
      const std::uint32_t bc = middle(b, c);
      const std::uint32_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (const Eigen::Vector3d& p : points) mesh.positions_m.push_back((radius_m * p + centre).cast<float>());
  return mesh;
}

/// How far the middle of an icosphere's triangle lies below the sphere, at most.
inline double chord_error_m(double radius_m, int levels) {
  constexpr double kIcosahedronEdge_rad = 1.1072;  // atan 2
  constexpr double kLargestEdge = 1.25;            // of the mean: in the middle of the first faces they are longest
  const double edge = radius_m * kLargestEdge * kIcosahedronEdge_rad / std::pow(2.0, levels);
  return edge * edge / (6 * radius_m);  // sagitta at a triangle's centre: (edge / sqrt 3)^2 / (2 r)
}

}  // namespace scanknit::test
