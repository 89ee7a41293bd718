#include "export/tiles/tile_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

namespace scanknit {
namespace {

constexpr std::size_t kOctants = 8;
constexpr double kSmallestCube = 0x1p-24;  // of the root's side: floats are no finer

Eigen::Vector3d centroid(const Mesh& mesh, const Triangle& t) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::uint32_t vertex : t) sum += mesh.positions_m[vertex].cast<double>();
  return sum / 3;
}

Eigen::AlignedBox3d box_of(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t vertex : t) box.extend(mesh.positions_m[vertex].cast<double>());
  }
  return box;
}

}  // namespace

TileTree::TileTree(const Mesh& mesh, std::size_t most_triangles)
    : mesh_(mesh),
      most_triangles_(most_triangles),
      triangles_(mesh.triangles.size()),
      first_leaf_(mesh.positions_m.size(), std::numeric_limits<std::uint32_t>::max()),
      last_leaf_(mesh.positions_m.size()) {
  std::iota(triangles_.begin(), triangles_.end(), 0u);
  const Eigen::AlignedBox3d box = box_of(mesh);
  root_.name = "r";
  divide(triangles_, {box.center(), box.sizes().maxCoeff() / 2}, root_);
}

std::size_t TileTree::octant_of(std::uint32_t triangle, const Cube& cube) const {
  const Eigen::Vector3d p = centroid(mesh_, mesh_.triangles[triangle]);
  const auto is_upper = [&](int axis) { return p[axis] >= cube.centre_m[axis] ? 1u : 0u; };
  return is_upper(0) + 2 * is_upper(1) + 4 * is_upper(2);
}

void TileTree::divide(std::span<std::uint32_t> triangles, Cube cube, TileNode& node) {
  node.triangles = triangles;
  node.first_leaf = leaves_;
  const double smallest_m = cube.half_m * kSmallestCube;
  std::array<std::size_t, kOctants + 1> ends{};  // of the octants, from the second entry on
  while (true) {
    if (triangles.size() <= most_triangles_ || !(cube.half_m > smallest_m)) return close_leaf(node);
    std::vector<std::uint8_t> octants(triangles.size());
    for (std::size_t i = 0; i < octants.size(); ++i) {
      octants[i] = static_cast<std::uint8_t>(octant_of(triangles[i], cube));
    }
    ends = {};
    for (const std::uint8_t octant : octants) ++ends[octant + 1u];
    const bool is_split = std::count(ends.begin(), ends.end(), std::size_t{0}) < std::ptrdiff_t{kOctants};
    if (!is_split) {  // all in one: go on in that
      const std::uint8_t only = octants.front();
      for (int axis = 0; axis < 3; ++axis) cube.centre_m[axis] += ((only >> axis & 1) != 0 ? 0.5 : -0.5) * cube.half_m;
      cube.half_m /= 2;
      continue;
    }
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<std::uint32_t> sorted(triangles.size());
    auto place = ends;
    for (std::size_t i = 0; i < octants.size(); ++i) sorted[place[octants[i]]++] = triangles[i];
    std::copy(sorted.begin(), sorted.end(), triangles.begin());
    break;
  }
  for (std::size_t octant = 0; octant < kOctants; ++octant) {
    const auto part = triangles.subspan(ends[octant], ends[octant + 1] - ends[octant]);
    if (part.empty()) continue;
    Cube child{cube.centre_m, cube.half_m / 2};
    for (int axis = 0; axis < 3; ++axis)
      child.centre_m[axis] += (octant >> axis & 1) != 0 ? child.half_m : -child.half_m;
    node.children.emplace_back().name = node.name + static_cast<char>('0' + octant);
    divide(part, child, node.children.back());
  }
  node.leaves_before = leaves_;
}

void TileTree::close_leaf(TileNode& node) {
  for (const std::uint32_t triangle : node.triangles) {
    for (const std::uint32_t vertex : mesh_.triangles[triangle]) {
      first_leaf_[vertex] = std::min(first_leaf_[vertex], leaves_);
      last_leaf_[vertex] = std::max(last_leaf_[vertex], leaves_);
    }
  }
  node.leaves_before = ++leaves_;
}

}  // namespace scanknit
