#include "finish/invented.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "core/mesh/mesh_area.h"
#include "finish/mesh_edges.h"

namespace scanknit {
namespace {

using Index = std::uint32_t;

struct Patch {
  Eigen::AlignedBox3f box;
  bool touches_seen = false;
  bool is_open = false;  ///< it has an edge that no other triangle shares
};

/// The lowest sample of the cell that the triangle was extracted from.
Eigen::Vector3i cell_of(const Mesh& mesh, const Triangle& triangle, const ClosedVolume& closed) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // the centroid lies within the triangle's cell
  for (const Index vertex : triangle) middle += mesh.positions_m[vertex].cast<double>() / 3;
  const Eigen::Vector3d index = closed.index_of(middle);
  return index.array().floor().cast<int>();
}

}  // namespace

std::vector<std::uint8_t> invented_triangles(const Mesh& mesh, const ClosedVolume& closed) {
  std::vector<std::uint8_t> invented(mesh.triangles.size());
  tbb::parallel_for(std::size_t{0}, invented.size(), [&](std::size_t i) {
    invented[i] = closed.is_seen_cell(cell_of(mesh, mesh.triangles[i], closed)) ? 0 : 1;
  });
  return invented;
}

std::vector<std::uint8_t> triangles_left_out(const Mesh& before, const Mesh& after, const ClosedVolume& closed) {
  const auto cell_in_box = [&](const Mesh& mesh, const Triangle& triangle) -> std::optional<std::size_t> {
    const Eigen::Vector3i place = cell_of(mesh, triangle, closed) - closed.box.first;
    if (!closed.box.contains(place.x(), place.y(), place.z())) return std::nullopt;
    return closed.box.at(place.x(), place.y(), place.z());
  };
  std::vector<std::uint8_t> has_surface(closed.box.voxels());
  for (const Triangle& triangle : after.triangles) {
    if (const auto cell = cell_in_box(after, triangle)) has_surface[*cell] = 1;
  }
  std::vector<std::uint8_t> left_out(before.triangles.size());
  tbb::parallel_for(std::size_t{0}, left_out.size(), [&](std::size_t i) {
    const auto cell = cell_in_box(before, before.triangles[i]);
    left_out[i] = cell && has_surface[*cell] != 0 ? 0 : 1;
  });
  return left_out;
}

PatchCount keep_small_patches(double max_size_m, Mesh& mesh, std::vector<std::uint8_t>& invented) {
  const std::vector<EdgeSide> sides = edge_sides(mesh);
  DisjointSets sets(mesh.triangles.size());
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    for (std::size_t i = 1; i < edge.size(); ++i) {
      if (invented[edge[i].triangle] != 0 && invented[edge[0].triangle] != 0) {
        sets.join(edge[0].triangle, edge[i].triangle);
      }
    }
  });
  std::vector<Patch> patches(mesh.triangles.size());  // indexed by root
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    bool has_seen = false;
    for (const EdgeSide& side : edge) has_seen |= invented[side.triangle] == 0;
    for (const EdgeSide& side : edge) {
      if (invented[side.triangle] == 0) continue;
      Patch& patch = patches[sets.root(side.triangle)];
      patch.touches_seen |= has_seen;
      patch.is_open |= edge.size() == 1;
      patch.box.extend(mesh.positions_m[side.low]);
      patch.box.extend(mesh.positions_m[side.high]);
    }
  });
  PatchCount count;
  std::vector<std::uint8_t> keeps(invented.size(), 1);
  std::vector<std::uint8_t> still_invented;
  for (Index i = 0; i < invented.size(); ++i) {
    if (invented[i] != 0) {
      const Patch& patch = patches[sets.root(i)];
      const bool is_small = static_cast<double>(patch.box.diagonal().norm()) <= max_size_m;
      keeps[i] = is_small && patch.touches_seen && !patch.is_open ? 1 : 0;
      if (sets.root(i) == i && patch.touches_seen) ++(keeps[i] != 0 ? count.kept : count.left_open);
    }
    if (keeps[i] != 0) still_invented.push_back(invented[i]);
  }
  keep_triangles(keeps, mesh);
  split_fans(mesh);
  invented = std::move(still_invented);
  return count;
}

void drop_invented_pieces(std::size_t min_triangles, Mesh& mesh, std::vector<std::uint8_t>& invented) {
  DisjointSets pieces(mesh.positions_m.size());
  for (const Triangle& t : mesh.triangles) {
    pieces.join(t[0], t[1]);
    pieces.join(t[0], t[2]);
  }
  std::vector<std::uint8_t> was_seen(mesh.positions_m.size());
  std::vector<std::size_t> triangles(mesh.positions_m.size());
  for (std::size_t i = 0; i < invented.size(); ++i) {
    const Index piece = pieces.root(mesh.triangles[i][0]);
    if (invented[i] == 0) was_seen[piece] = 1;
    ++triangles[piece];
  }
  std::vector<std::uint8_t> keeps(invented.size());
  std::vector<std::uint8_t> still_invented;
  for (std::size_t i = 0; i < invented.size(); ++i) {
    const Index piece = pieces.root(mesh.triangles[i][0]);
    keeps[i] = was_seen[piece] != 0 && triangles[piece] >= min_triangles ? 1 : 0;
    if (keeps[i] != 0) still_invented.push_back(invented[i]);
  }
  keep_triangles(keeps, mesh);
  invented = std::move(still_invented);
}

void paint_invented(const std::vector<std::uint8_t>& invented, Rgb8 colour, Mesh& mesh) {
  constexpr Rgb8 kGrey{128, 128, 128};
  if (mesh.colours.empty()) mesh.colours.assign(mesh.positions_m.size(), kGrey);
  std::vector<std::uint8_t> was_seen(mesh.positions_m.size());
  for (std::size_t i = 0; i < invented.size(); ++i) {
    if (invented[i] != 0) continue;
    for (const Index vertex : mesh.triangles[i]) was_seen[vertex] = 1;
  }
  for (std::size_t i = 0; i < was_seen.size(); ++i) {
    if (was_seen[i] == 0) mesh.colours[i] = colour;
  }
}

double area_m2(const Mesh& mesh, const std::vector<std::uint8_t>& triangles) {
  double area = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (triangles[i] != 0) area += area_vector_m2(mesh, mesh.triangles[i]).norm();
  }
  return area;
}

}  // namespace scanknit
