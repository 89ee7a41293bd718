// Meshes for the export tests.
#pragma once

#include "tests/core/sample_meshes.h"

namespace scanknit::test {

/// A marker on each axis of an otherwise grey sphere: red at +x, green at +y, blue at +z. Not symmetric in any way, so
/// that a wrong turn or a mirror shows.
inline Mesh marked_sphere() {
  Mesh mesh = sphere();
  constexpr float kCap = 0.8f;  // cosine of the caps' opening
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    Rgb8 colour{188, 188, 188};
    if (p.x() > kCap) colour = {200, 60, 40};
    if (p.y() > kCap) colour = {60, 180, 75};
    if (p.z() > kCap) colour = {40, 90, 200};
    mesh.colours.push_back(colour);
  }
  return mesh;
}

/// A tetrahedron with one corner on each axis, coloured by it, and awkward floats.
inline Mesh small_mesh() {
  Mesh mesh = tetrahedron();
  mesh.positions_m[0] = {-0.1f, 1.0f / 3, 1e-7f};
  mesh.positions_m[1].x() = 1234.5678f;
  mesh.colours = {{0, 0, 0}, {255, 1, 2}, {3, 254, 128}, {77, 99, 255}};
  for (const Eigen::Vector3f& p : mesh.positions_m) mesh.normals.push_back((p + Eigen::Vector3f(1, 2, 3)).normalized());
  return mesh;
}

}  // namespace scanknit::test
