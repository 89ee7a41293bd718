#include "view/split_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>

#include "core/check.h"

namespace scanknit {
namespace {

using Numbers = std::span<std::uint32_t>;  // of triangles

Eigen::Vector3f centre_of(const Mesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (mesh.positions_m[a] + mesh.positions_m[b] + mesh.positions_m[c]) / 3;
}

/// Sorts `numbers` so that its halves lie on two sides of a plane; gives the first half's length.
std::size_t halve(const Mesh& mesh, Numbers numbers) {
  Eigen::AlignedBox3f box;
  for (const std::uint32_t triangle : numbers) box.extend(centre_of(mesh, triangle));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t half = numbers.size() / 2;
  std::nth_element(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(half), numbers.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float at_a = centre_of(mesh, a)[axis];
                     const float at_b = centre_of(mesh, b)[axis];
                     return at_a != at_b ? at_a < at_b : a < b;
                   });
  return half;
}

/// `number_of` is as long as the mesh's vertices and 0 throughout, before and after.
Mesh piece_of(const Mesh& mesh, Numbers numbers, std::vector<std::uint32_t>& number_of) {
  std::sort(numbers.begin(), numbers.end());
  Mesh piece;
  std::vector<std::uint32_t> used;
  for (const std::uint32_t triangle : numbers) {
    Triangle corners = mesh.triangles[triangle];
    for (std::uint32_t& vertex : corners) {
      if (number_of[vertex] == 0) {
        used.push_back(vertex);
        number_of[vertex] = static_cast<std::uint32_t>(used.size());
      }
      vertex = number_of[vertex] - 1;
    }
    piece.triangles.push_back(corners);
  }
  for (const std::uint32_t vertex : used) {
    piece.positions_m.push_back(mesh.positions_m[vertex]);
    if (!mesh.normals.empty()) piece.normals.push_back(mesh.normals[vertex]);
    if (!mesh.colours.empty()) piece.colours.push_back(mesh.colours[vertex]);
    number_of[vertex] = 0;
  }
  return piece;
}

}  // namespace

std::vector<Mesh> split_mesh(const Mesh& mesh, std::size_t most_triangles) {
  SCANKNIT_CHECK(most_triangles > 0);
  std::vector<std::uint32_t> numbers(mesh.triangles.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  std::vector<std::uint32_t> number_of(mesh.positions_m.size());
  std::vector<Mesh> pieces;
  std::vector<Numbers> waiting;
  if (!numbers.empty()) waiting.emplace_back(numbers);
  while (!waiting.empty()) {
    const Numbers some = waiting.back();
    waiting.pop_back();
    if (some.size() <= most_triangles) {
      pieces.push_back(piece_of(mesh, some, number_of));
      continue;
    }
    const std::size_t half = halve(mesh, some);
    waiting.push_back(some.subspan(half));
    waiting.push_back(some.first(half));
  }
  return pieces;
}

}  // namespace scanknit
