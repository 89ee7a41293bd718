#include "measure/solid/volume.h"

#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

namespace scanknit {
namespace {

using Eigen::Vector3d;

struct DirectedSide {
  std::uint32_t low, high;
  bool is_upwards;

  [[nodiscard]] std::uint32_t from() const { return is_upwards ? low : high; }
  [[nodiscard]] std::uint32_t to() const { return is_upwards ? high : low; }
};

std::vector<DirectedSide> sorted_sides(const Mesh& mesh) {
  std::vector<DirectedSide> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = t[k], to = t[(k + 1) % 3];
      if (from != to) sides.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  }
  tbb::parallel_sort(sides.begin(), sides.end(), [](const DirectedSide& a, const DirectedSide& b) {
    return std::tie(a.low, a.high, a.is_upwards) < std::tie(b.low, b.high, b.is_upwards);
  });
  return sides;
}

/// Six times the volume of the tetrahedron of a triangle and the origin.
double six_volumes(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return a.dot(b.cross(c));
}

/// Covers rims with fans about their middles. `rim` are the sides of triangles that have no neighbour.
double six_volumes_of_covers(const Mesh& mesh, std::vector<DirectedSide> rim, const Vector3d& origin) {
  std::sort(rim.begin(), rim.end(), [](const DirectedSide& a, const DirectedSide& b) {
    return std::tuple(a.from(), a.to()) < std::tuple(b.from(), b.to());
  });
  const auto at = [&](std::uint32_t v) -> Vector3d { return mesh.positions_m[v].cast<double>() - origin; };
  std::vector<bool> is_walked(rim.size(), false);
  const auto next_from = [&](std::uint32_t vertex) {
    const auto first = std::lower_bound(rim.begin(), rim.end(), vertex,
                                        [](const DirectedSide& side, std::uint32_t v) { return side.from() < v; });
    auto i = static_cast<std::size_t>(first - rim.begin());
    while (i < rim.size() && rim[i].from() == vertex && is_walked[i]) ++i;
    return i < rim.size() && rim[i].from() == vertex ? i : rim.size();
  };
  double sum = 0;
  for (std::size_t begin = 0; begin < rim.size(); ++begin) {
    std::vector<std::size_t> loop;
    for (std::size_t i = begin; i < rim.size() && !is_walked[i]; i = next_from(rim[i].to())) {
      is_walked[i] = true;
      loop.push_back(i);
    }
    Vector3d middle = Vector3d::Zero();
    double length = 0;
    for (const std::size_t i : loop) {
      const Vector3d a = at(rim[i].from()), b = at(rim[i].to());
      middle += (a + b) / 2 * (b - a).norm();
      length += (b - a).norm();
    }
    if (length > 0) middle /= length;
    for (const std::size_t i : loop) sum += six_volumes(at(rim[i].to()), at(rim[i].from()), middle);
  }
  return sum;
}

}  // namespace

MeshVolume measure_volume(const Mesh& mesh) {
  MeshVolume measured;
  if (mesh.empty()) return measured;
  std::vector<DirectedSide> rim;
  const std::vector<DirectedSide> sides = sorted_sides(mesh);
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin, upwards = 0;
    for (; end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high; ++end) {
      upwards += sides[end].is_upwards ? 1 : 0;
    }
    const std::size_t count = end - begin;
    if (count == 1) {
      rim.push_back(sides[begin]);
    } else if (2 * upwards != count) {
      ++measured.tangled_edges;
    }
    begin = end;
  }
  measured.border_edges = rim.size();
  if (measured.tangled_edges > 0) return measured;

  const Vector3d origin = mesh.positions_m[mesh.triangles.front()[0]].cast<double>();  // near: keeps digits
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](std::uint32_t v) -> Vector3d { return mesh.positions_m[v].cast<double>() - origin; };
    sum += six_volumes(at(a), at(b), at(c));
  }
  if (rim.empty()) {
    measured.volume_m3 = std::abs(sum) / 6;
  } else {
    sum += six_volumes_of_covers(mesh, std::move(rim), origin);
    measured.covered_volume_m3 = std::abs(sum) / 6;
  }
  measured.is_inside_out = sum < 0;
  return measured;
}

}  // namespace scanknit
