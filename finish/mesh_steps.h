// The steps that finish a mesh: small pieces go, it is smoothed, simplified, and placed.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/mesh.h"
#include "core/pose.h"

namespace scanknit {

struct PiecesRemoved {
  std::size_t pieces = 0, triangles = 0;
  double area_m2 = 0;
};

/// Removes the pieces (triangles joined by vertices) whose area is less than `min_share` of the largest one's, or whose
/// bounding box has a diagonal below `min_size_m`. The largest piece stays. The order of what stays is unchanged.
PiecesRemoved remove_small_pieces(double min_share, double min_size_m, Mesh& mesh);

/// What a mesh loses when the triangles marked with a 1 are left out: they and their area, and the pieces of which
/// nothing stays.
[[nodiscard]] PiecesRemoved count_removed(const Mesh& mesh, const std::vector<std::uint8_t>& is_left_out);

struct MeshMoved {
  double mean_m = 0, max_m = 0;  ///< of the vertices
  bool is_stopped = false;       ///< then nothing has moved
};

/// Taubin 1995, "A signal processing approach to fair surface design": `steps` times a step of 0.5 towards the mean of
/// the neighbours, and one of -0.53 back, which lets waves longer than some 12 edges pass. Boundaries stay where they
/// are. Every closed piece keeps its volume: every ten steps, and in the end, it is moved along its normals by the one
/// distance that gives it back. Normals are made anew where there were any. Asked for by `stop`, it ends and
/// leaves the mesh as it was. The same bits for any number of threads.
MeshMoved smooth_mesh(std::size_t steps, Mesh& mesh, const std::stop_token& stop = {});

/// The normals of the triangles, weighted by area; a vertex whose normals cancel out keeps the one it has, if any.
void renew_normals(Mesh& mesh);

struct SimplifyWish {
  std::optional<std::size_t> triangles;  ///< at least so many stay; nothing: as few as the error allows
  std::optional<double> max_error_m;     ///< nothing: whatever it takes
};

struct MeshSimplified {
  std::size_t triangles_before = 0, triangles = 0;
  std::size_t pieces_lost = 0;
  double error_m = 0;  ///< of the quadrics; an estimate of how far the surface moved
  /// The wish would have broken the topology: there is a hundredth more triangles than asked for, or more.
  bool is_held_back = false;
};

/// meshoptimizer's edge collapses onto vertices that are there, so that each vertex keeps its place, normal and colour.
/// What was manifold stays so, closed stays closed with all its rings, but small pieces may vanish. What would break
/// this is kept as it was; where that is too much, the mesh is simplified in steps, as far as they go. Deterministic.
MeshSimplified simplify_mesh(const SimplifyWish& wish, Mesh& mesh);

/// The smallest rotation, about the origin, that turns `up` (unit) into `wanted_up` (unit).
[[nodiscard]] Pose turn_up(const Eigen::Vector3d& up, const Eigen::Vector3d& wanted_up);

/// The shift that puts the lowest vertex at height 0 along `up` (unit, along an axis), and the middle of the bounding
/// box over the origin.
[[nodiscard]] Pose stand_on_origin(const Mesh& mesh, const Eigen::Vector3d& up);

/// Moves positions and normals.
void transform_mesh(const Pose& T, Mesh& mesh);

}  // namespace scanknit
