#include "export/mesh/mesh_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <tuple>
#include <vector>

namespace scanknit {
namespace {

/// The position's bits, so that "equal" is exact; a corner of the soup knows where it stands in it.
struct SoupCorner {
  std::array<std::uint32_t, 3> bits;
  std::uint32_t place;
};

}  // namespace

Result<void> add_polygon(std::span<const std::uint32_t> corners, const Limits& limits, Mesh& mesh) {
  if (corners.size() < 3) return {};
  if (corners.size() - 2 > limits.max_mesh_triangles - std::min(mesh.triangles.size(), limits.max_mesh_triangles)) {
    return input_error(fmt::format("more triangles than the limit of {}", limits.max_mesh_triangles));
  }
  for (std::size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  return {};
}

Mesh weld(std::span<const Eigen::Vector3f> soup) {
  std::vector<SoupCorner> corners(soup.size());
  for (std::uint32_t i = 0; i < soup.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const float coordinate = soup[i][axis] + 0.0f;  // -0 becomes 0: the one pair of equal numbers with other bits
      corners[i].bits[static_cast<std::size_t>(axis)] = std::bit_cast<std::uint32_t>(coordinate);
    }
    corners[i].place = i;
  }
  std::sort(corners.begin(), corners.end(), [](const SoupCorner& a, const SoupCorner& b) {
    return std::tie(a.bits, a.place) < std::tie(b.bits, b.place);
  });
  std::vector<std::uint32_t> first_place(soup.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const bool is_repeat = i > 0 && corners[i].bits == corners[i - 1].bits;
    first_place[corners[i].place] = is_repeat ? first_place[corners[i - 1].place] : corners[i].place;
  }
  Mesh mesh;
  mesh.triangles.resize(soup.size() / 3);
  std::vector<std::uint32_t> vertex(soup.size());
  for (std::uint32_t i = 0; i < soup.size(); ++i) {
    if (first_place[i] == i) {
      vertex[i] = static_cast<std::uint32_t>(mesh.positions_m.size());
      mesh.positions_m.push_back(soup[i]);
    }
    mesh.triangles[i / 3][i % 3] = vertex[first_place[i]];
  }
  return mesh;
}

Result<Mesh> finish_mesh(Mesh mesh) {
  const std::size_t n = mesh.positions_m.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const std::uint32_t largest = std::max({t[0], t[1], t[2]});
    if (largest >= n) return input_error(fmt::format("a face names vertex {} of the {} there are", largest, n));
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!mesh.positions_m[i].allFinite()) return input_error(fmt::format("the position of vertex {} is not finite", i));
  }
  for (Eigen::Vector3f& normal : mesh.normals) {
    if (!normal.allFinite()) normal.setZero();
  }
  return mesh;
}

}  // namespace scanknit
