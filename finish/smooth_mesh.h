// Smooths a mesh without shrinking it.
#pragma once

#include <cstddef>
#include <stop_token>

#include "core/mesh.h"

namespace scanknit {

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

}  // namespace scanknit
