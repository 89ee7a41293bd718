// Small meshes with known topology.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/mesh.h"

namespace scanknit::test {

inline Mesh tetrahedron() {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

/// Side 2, centred at the origin: corner i is at +1 where bit 0, 1, 2 of i (x, y, z) is set.
inline Mesh cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions_m.emplace_back((i & 1) != 0 ? 1.0f : -1.0f, (i & 2) != 0 ? 1.0f : -1.0f,
                                  (i & 4) != 0 ? 1.0f : -1.0f);
  }
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

/// A closed grid that wraps round both ways: genus 1.
inline Mesh torus(std::uint32_t around = 24, std::uint32_t across = 12) {
  Mesh mesh;
  const auto angle = [](std::uint32_t i, std::uint32_t n) {
    return 2 * std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(n);
  };
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      const float a = angle(i, around), b = angle(j, across), r = 1 + 0.3f * std::cos(b);
      mesh.positions_m.emplace_back(r * std::cos(a), r * std::sin(a), 0.3f * std::sin(b));
      const std::uint32_t next_i = (i + 1) % around, next_j = (j + 1) % across;
      const std::uint32_t v00 = i * across + j, v10 = next_i * across + j;
      const std::uint32_t v01 = i * across + next_j, v11 = next_i * across + next_j;
      mesh.triangles.push_back({v00, v10, v11});
      mesh.triangles.push_back({v00, v11, v01});
    }
  }
  return mesh;
}

/// A sphere of latitude rings, radius 1, with poles at +-z and outward normals.
inline Mesh sphere(std::uint32_t rings = 48, std::uint32_t slices = 96) {
  Mesh mesh;
  mesh.positions_m.emplace_back(0, 0, 1);
  for (std::uint32_t i = 1; i < rings; ++i) {
    const float polar = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(rings);
    for (std::uint32_t j = 0; j < slices; ++j) {
      const float a = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(slices);
      mesh.positions_m.emplace_back(std::sin(polar) * std::cos(a), std::sin(polar) * std::sin(a), std::cos(polar));
    }
  }
  mesh.positions_m.emplace_back(0, 0, -1);
  const auto at = [&](std::uint32_t ring, std::uint32_t slice) { return 1 + (ring - 1) * slices + slice % slices; };
  const auto south = static_cast<std::uint32_t>(mesh.positions_m.size() - 1);
  for (std::uint32_t j = 0; j < slices; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    mesh.triangles.push_back({south, at(rings - 1, j + 1), at(rings - 1, j)});
    for (std::uint32_t i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  mesh.normals = mesh.positions_m;
  return mesh;
}

}  // namespace scanknit::test
