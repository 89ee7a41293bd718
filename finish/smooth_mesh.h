// Smoothing that does not shrink.
#pragma once

#include <cstddef>
#include <stop_token>

#include "core/mesh.h"

namespace scanknit {

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

}  // namespace scanknit
