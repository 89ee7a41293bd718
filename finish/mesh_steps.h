// The steps that finish a mesh: small pieces go, it is smoothed, simplified, and placed.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/mesh.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

struct PiecesRemoved {
  std::size_t pieces = 0, triangles = 0;
  double area_m2 = 0;
};

/// Removes the pieces (triangles joined by vertices) whose area is less than `min_share` of the largest one's, or whose
/// bounding box has a diagonal below `min_size_m`. The largest piece stays. The order of the rest is unchanged.
PiecesRemoved remove_small_pieces(double min_share, double min_size_m, Mesh& mesh);

/// The frames that have a reading of a vertex, and those that confirm it.
struct Confirmation {
  std::uint16_t readings = 0, views = 0;
};
/// Those of some of a mesh's vertices, in their order.
using ConfirmationsOf = std::function<std::vector<Confirmation>(std::span<const std::uint32_t> vertices)>;

/// Removes the pieces whose area is less than `max_share` of the largest one's and whose vertices, on average, fewer
/// than `least_views` frames confirm, or less than `least_share` of the frames that have a reading. The largest piece
/// stays. `confirmations_of` is asked about the vertices of small pieces alone, ascending, 65,536 at a time.
PiecesRemoved remove_unconfirmed_pieces(double max_share, const ConfirmationsOf& confirmations_of, double least_views,
                                        double least_share, Mesh& mesh);

/// What a mesh loses without the triangles marked with 1: these triangles, their area, and the pieces that vanish
/// completely.
[[nodiscard]] PiecesRemoved count_removed(const Mesh& mesh, const std::vector<std::uint8_t>& is_left_out);

struct MeshMoved {
  double mean_m = 0, max_m = 0;  ///< distances that vertices moved
  bool is_stopped = false;       ///< the stop was requested: no vertex has moved
};

/// Taubin 1995, "A signal processing approach to fair surface design": `steps` times a step of 0.5 towards the mean of
/// the neighbours and one of -0.53 back, which keeps waves longer than about 12 edges. Boundaries do not move. Every
/// closed piece keeps its volume: every ten steps, and at the end, all its vertices move along their normals by the one
/// distance that restores it. Computes normals again if the mesh has normals. On a stop request it returns with the
/// mesh unchanged. The same bits for any number of threads.
MeshMoved smooth_mesh(std::size_t steps, Mesh& mesh, const std::stop_token& stop = {});

/// Sets each vertex normal to the mean of its triangles' normals, weighted by area. If they cancel out, keeps the old
/// normal, if any.
void renew_normals(Mesh& mesh);

struct SimplifyTarget {
  std::optional<std::size_t> triangles;  ///< keep at least so many; nothing: as few as the error allows
  std::optional<double> max_error_m;     ///< nothing: no limit
};

struct MeshSimplified {
  std::size_t triangles_before = 0, triangles = 0;
  std::size_t pieces_lost = 0;
  double error_m = 0;  ///< quadric error: an estimate of how far the surface moved
  /// Reaching the target would change the topology: at least 1 % more triangles than asked for are left.
  bool is_held_back = false;
};

/// What simplify_mesh() takes beside the mesh: lists of three edges of a triangle, and the vertices' quadrics.
[[nodiscard]] std::size_t simplify_bytes(const Mesh& mesh);

/// Collapses edges onto existing vertices (meshoptimizer), so that each remaining vertex keeps its position, normal and
/// colour. A manifold mesh stays manifold, and a closed one stays closed with the same genus, but small pieces may
/// vanish. Keeps the triangles whose collapse would break this; if these are too many, simplifies in steps as far as
/// possible. Deterministic.
MeshSimplified simplify_mesh(const SimplifyTarget& target, Mesh& mesh);

/// The smallest rotation about the origin that turns `up` (unit) into `wanted_up` (unit).
[[nodiscard]] Pose turn_up(const Eigen::Vector3d& up, const Eigen::Vector3d& wanted_up);

/// The shift that puts the lowest vertex at height 0 along `up` (unit, along an axis), and the centre of the bounding
/// box over the origin.
[[nodiscard]] Pose stand_on_origin(const Mesh& mesh, const Eigen::Vector3d& up);

/// Transforms positions and normals.
void transform_mesh(const Pose& T, Mesh& mesh);

struct GroundPlane {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< unit, out of the ground
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double area_m2 = 0;   ///< area of the mesh that lies on it
  double share = 0;     ///< share of the mesh's area that lies on it
  double rms_m = 0;     ///< of the centres of that part's triangles
  double tilt_rad = 0;  ///< angle to the expected up direction

  [[nodiscard]] double height_m(const Eigen::Vector3d& p) const { return up.dot(p - point); }
};

struct GroundSearch {
  Eigen::Vector3d expected_up = Eigen::Vector3d::UnitZ();  ///< unit
  double max_tilt_rad = 0.785398;  ///< excludes walls; includes a scanner that looked down by less than this
  double tolerance_m = 0.008;      ///< points nearer than this belong to the plane
  double min_share = 0.05;         ///< of the mesh's area
};

/// The plane with most of the mesh on it, by RANSAC (Fischler & Bolles 1981, PCL's), fitted again to the part on it.
/// Deterministic. Nothing when no plane is found, or when what stands on the plane reaches beyond it: then the plane is
/// a plinth, part of the object. Error (kInternal): the module for PCL is missing (finish/finish_pcl.h).
[[nodiscard]] Result<std::optional<GroundPlane>> find_ground(const Mesh& mesh, const GroundSearch& search);

}  // namespace scanknit
