#include "finish/mesh_steps.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh_area.h"
#include "core/mesh/mesh_pieces.h"
#include "finish/mesh_edges.h"

namespace scanknit {
namespace {

using Index = std::uint32_t;

// Taubin's lambda and mu: the pass-band ends at 1 / lambda + 1 / mu = 0.113.
constexpr double kForward = 0.5;
constexpr double kBack = -0.53;

/// The neighbours of each vertex; none for vertices on a boundary or on an edge with more than two sides.
struct Neighbours {
  std::vector<std::size_t> begin;
  std::vector<Index> vertices;
};

Neighbours neighbours_of(const Mesh& mesh) {
  const std::vector<EdgeSide> sides = edge_sides(mesh);
  std::vector<std::uint8_t> is_fixed(mesh.positions_m.size());
  std::vector<std::size_t> count(mesh.positions_m.size() + 1);
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    ++count[edge[0].low + 1];
    ++count[edge[0].high + 1];
    if (edge.size() == 2) return;
    is_fixed[edge[0].low] = 1;
    is_fixed[edge[0].high] = 1;
  });
  for (std::size_t v = 0; v < is_fixed.size(); ++v) {
    if (is_fixed[v] != 0) count[v + 1] = 0;
    count[v + 1] += count[v];
  }
  Neighbours found{count, std::vector<Index>(count.back())};
  const auto put = [&](Index v, Index neighbour) {
    if (is_fixed[v] == 0) found.vertices[count[v]++] = neighbour;
  };
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    put(edge[0].low, edge[0].high);
    put(edge[0].high, edge[0].low);
  });
  return found;
}

/// Steps between two corrections of the volume, in which it drifts by less than a thousandth.
constexpr std::size_t kStepsBetween = 10;

/// Restores the volume of each closed piece. Taubin's filter keeps flat parts, but amplifies long waves a little with
/// each step: up to 8 % of the volume in a thousand steps.
class VolumeKeeper {
 public:
  VolumeKeeper(const Mesh& mesh, const Neighbours& neighbours, const std::vector<Eigen::Vector3d>& positions)
      : mesh_(mesh), sets_(pieces_of(mesh)), piece_of_(positions.size()) {
    std::vector<Index> number(positions.size());
    Index pieces = 0;
    for (Index v = 0; v < positions.size(); ++v) {
      if (sets_.root(v) == v) number[v] = pieces++;
      piece_of_[v] = number[sets_.root(v)];
    }
    has_volume_.assign(pieces, 1);
    for (Index v = 0; v < positions.size(); ++v) {
      if (neighbours.begin[v] == neighbours.begin[v + 1]) has_volume_[piece_of_[v]] = 0;  // it has a boundary
    }
    volumes_ = volumes_of(positions);
  }

  /// Moves all vertices of a piece by the same distance along the surface normal.
  void restore(std::vector<Eigen::Vector3d>& positions) const {
    std::vector<Eigen::Vector3d> area(positions.size(), Eigen::Vector3d::Zero());  // area times normal
    for (const Triangle& t : mesh_.triangles) {
      const Eigen::Vector3d twice = (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]);
      for (const Index vertex : t) area[vertex] += twice / 6;
    }
    std::vector<double> distance = volumes_of(positions), grown_by_one(distance.size(), 0);
    for (Index v = 0; v < positions.size(); ++v) grown_by_one[piece_of_[v]] += area[v].norm();
    for (std::size_t piece = 0; piece < distance.size(); ++piece) {
      const bool can_be_moved = has_volume_[piece] != 0 && grown_by_one[piece] > 0;
      distance[piece] = can_be_moved ? (volumes_[piece] - distance[piece]) / grown_by_one[piece] : 0;
    }
    for (Index v = 0; v < positions.size(); ++v) {
      const double length = area[v].norm();
      if (length > 0) positions[v] += distance[piece_of_[v]] / length * area[v];
    }
  }

 private:
  [[nodiscard]] std::vector<double> volumes_of(const std::vector<Eigen::Vector3d>& positions) const {
    std::vector<double> volumes(has_volume_.size(), 0);
    std::vector<Eigen::Vector3d> origins(has_volume_.size(),
                                         Eigen::Vector3d::Zero());  // a point of the piece, for numerical precision
    for (Index v = 0; v < positions.size(); ++v) origins[piece_of_[v]] = positions[v];
    for (const Triangle& t : mesh_.triangles) {
      const Index piece = piece_of_[t[0]];
      const Eigen::Vector3d a = positions[t[0]] - origins[piece], b = positions[t[1]] - origins[piece];
      volumes[piece] += a.dot(b.cross(positions[t[2]] - origins[piece])) / 6;
    }
    return volumes;
  }

  const Mesh& mesh_;
  DisjointSets sets_;
  std::vector<Index> piece_of_;
  std::vector<std::uint8_t> has_volume_;
  std::vector<double> volumes_;
};

}  // namespace

MeshMoved smooth_mesh(std::size_t steps, Mesh& mesh, const std::stop_token& stop) {
  const Neighbours neighbours = neighbours_of(mesh);
  const std::size_t n = mesh.positions_m.size();
  std::vector<Eigen::Vector3d> now(n), next(n);
  for (std::size_t v = 0; v < n; ++v) now[v] = mesh.positions_m[v].cast<double>();
  const VolumeKeeper volume(mesh, neighbours, now);
  for (std::size_t pass = 0; pass < 2 * steps; ++pass) {
    if (stop.stop_requested()) return {.is_stopped = true};
    const double step = pass % 2 == 0 ? kForward : kBack;
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t v) {
      const std::size_t begin = neighbours.begin[v];
      const std::size_t end = neighbours.begin[v + 1];
      next[v] = now[v];
      if (begin == end) return;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (std::size_t i = begin; i < end; ++i) mean += now[neighbours.vertices[i]];
      next[v] += step * (mean / static_cast<double>(end - begin) - now[v]);
    });
    now.swap(next);
    if (pass % (2 * kStepsBetween) == 2 * kStepsBetween - 1) volume.restore(now);
  }
  for (int i = 0; i < 2; ++i) volume.restore(now);  // two Newton steps: the second one removes rounding
  MeshMoved moved;
  for (std::size_t v = 0; v < n; ++v) {
    const double distance = (now[v] - mesh.positions_m[v].cast<double>()).norm();
    moved.mean_m += distance / static_cast<double>(n);
    moved.max_m = std::max(moved.max_m, distance);
    mesh.positions_m[v] = now[v].cast<float>();
  }
  if (!mesh.normals.empty()) renew_normals(mesh);
  return moved;
}

void renew_normals(Mesh& mesh) {
  std::vector<Eigen::Vector3d> sum(mesh.positions_m.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d area = area_vector_m2(mesh, t);
    for (const Index vertex : t) sum[vertex] += area;
  }
  mesh.normals.resize(mesh.positions_m.size(), Eigen::Vector3f::Zero());
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const double length = sum[v].norm();
    if (length > 0) mesh.normals[v] = (sum[v] / length).cast<float>();
  }
}

}  // namespace scanknit
