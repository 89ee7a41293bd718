// The uncertainty of a mesh's vertices, from the volume that it was extracted from.
#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "core/field_view.h"
#include "core/mesh.h"
#include "core/pose.h"

namespace scanknit {

/// What turns a weight into a standard deviation.
struct UncertaintyScale {
  double view_sigma_m = 0;  ///< of one view of weight 1: ViewSpread::view_sigma_m()
  double voxel_size_m = 0;
};

/// What a volume says at each vertex of a mesh.
struct VertexEvidence {
  explicit VertexEvidence(std::size_t vertices) : weight(vertices, 0.0f), bend_m(vertices, 0.0f) {}

  std::vector<float> weight;  ///< weight_at()
  /// How far the surface leaves its tangent plane two voxels beside the vertex, where most: at edges and corners, and
  /// where it is rough.
  std::vector<float> bend_m;
};

/// Reads the vertices whose cell is at begin_x <= x < end_x, index coordinates; the view reaches four voxels beyond.
/// Of several views of a vertex, the most counts. A view without weights changes nothing. The same bits for any number
/// of threads.
void add_evidence(const Mesh& mesh, const Pose& T_world_mesh, const FieldView& view, VertexEvidence& evidence,
                  int begin_x = std::numeric_limits<int>::min(), int end_x = std::numeric_limits<int>::max());

/// One standard deviation of a vertex's place along its normal, metres; NaN for a weight of 0. See
/// docs/formats.md#uncertainty for what it is made of and how well it holds.
[[nodiscard]] float uncertainty_m(float weight, float bend_m, const UncertaintyScale& scale);

/// uncertainty_m() of each.
[[nodiscard]] std::vector<float> uncertainties_m(const VertexEvidence& evidence, const UncertaintyScale& scale);

}  // namespace scanknit
