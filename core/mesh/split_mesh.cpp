#include "core/mesh/split_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <utility>

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

}  // namespace

MeshSplit::MeshSplit(const Mesh& mesh, MostOfAPart most)
    : mesh_(mesh), triangles_(mesh.triangles.size()), number_of_(mesh.positions_m.size(), 0) {
  SCANKNIT_CHECK(most.triangles > 0 && most.vertices > 0);
  std::iota(triangles_.begin(), triangles_.end(), 0u);
  std::vector<Numbers> waiting;
  if (!triangles_.empty()) waiting.emplace_back(triangles_);
  while (!waiting.empty()) {
    const Numbers some = waiting.back();
    waiting.pop_back();
    const std::size_t vertices = count_vertices(some);
    if (some.size() == 1 || (some.size() <= most.triangles && vertices <= most.vertices)) {
      std::sort(some.begin(), some.end());
      parts_.push_back({some, vertices});
      continue;
    }
    const std::size_t half = halve(mesh, some);
    waiting.push_back(some.subspan(half));
    waiting.push_back(some.first(half));
  }
}

std::size_t MeshSplit::count_vertices(std::span<const std::uint32_t> triangles) {
  std::size_t count = 0;
  for (const std::uint32_t triangle : triangles) {
    for (const std::uint32_t vertex : mesh_.triangles[triangle]) count += std::exchange(number_of_[vertex], 1u) == 0;
  }
  for (const std::uint32_t triangle : triangles) {
    for (const std::uint32_t vertex : mesh_.triangles[triangle]) number_of_[vertex] = 0;
  }
  return count;
}

std::size_t MeshSplit::vertices() const {
  std::size_t sum = 0;
  for (const Box& part : parts_) sum += part.vertices;
  return sum;
}

MeshPart MeshSplit::part(std::size_t i) {
  const Box& box = parts_.at(i);
  MeshPart part;
  part.vertices.reserve(box.vertices);
  part.triangles.reserve(box.triangles.size());
  for (const std::uint32_t triangle : box.triangles) {
    Triangle corners = mesh_.triangles[triangle];
    for (std::uint32_t& vertex : corners) {
      std::uint32_t& number = number_of_[vertex];
      if (number == 0) {
        part.vertices.push_back(vertex);
        number = static_cast<std::uint32_t>(part.vertices.size());
      }
      vertex = number - 1;
    }
    part.triangles.push_back(corners);
  }
  for (const std::uint32_t vertex : part.vertices) number_of_[vertex] = 0;
  return part;
}

MeshPart part_of(std::span<const Triangle> triangles) {
  MeshPart part;
  part.vertices.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) part.vertices.insert(part.vertices.end(), t.begin(), t.end());
  std::sort(part.vertices.begin(), part.vertices.end());
  part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
  const auto local = [&](std::uint32_t vertex) {
    const auto found = std::lower_bound(part.vertices.begin(), part.vertices.end(), vertex);
    return static_cast<std::uint32_t>(found - part.vertices.begin());
  };
  part.triangles.reserve(triangles.size());
  for (const Triangle& t : triangles) part.triangles.emplace_back(local(t[0]), local(t[1]), local(t[2]));
  return part;
}

Mesh mesh_of_part(const Mesh& mesh, MeshPart part) {
  Mesh own;
  for (const std::uint32_t vertex : part.vertices) {
    own.positions_m.push_back(mesh.positions_m[vertex]);
    if (!mesh.normals.empty()) own.normals.push_back(mesh.normals[vertex]);
    if (!mesh.colours.empty()) own.colours.push_back(mesh.colours[vertex]);
  }
  own.triangles = std::move(part.triangles);
  return own;
}

std::vector<Mesh> split_mesh(const Mesh& mesh, std::size_t most_triangles) {
  MeshSplit split(mesh, {.triangles = most_triangles});
  std::vector<Mesh> meshes;
  for (std::size_t i = 0; i < split.parts(); ++i) meshes.push_back(mesh_of_part(mesh, split.part(i)));
  return meshes;
}

}  // namespace scanknit
