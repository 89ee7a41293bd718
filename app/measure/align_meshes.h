// Brings a mesh onto its reference, as `distance` was told.
#pragma once

#include "app/measure/measure_arguments.h"
#include "app/measure/measured_mesh.h"
#include "core/pose.h"

namespace scanknit {

struct MeshPlacement {
  Pose T_reference_mesh = Pose::Identity();
  bool is_ambiguous = false;  ///< other placements fit as well
};

/// Errors (kInput): files of pairs or of a matrix that cannot be used.
[[nodiscard]] Result<MeshPlacement> align_meshes(const MeasuredMesh& mesh, const MeasuredMesh& reference,
                                                 const ComparisonArguments& arguments);

}  // namespace scanknit
