// Chooses the size of texels.
#pragma once

#include <optional>
#include <span>

#include "core/camera.h"
#include "core/mesh.h"
#include "core/pose.h"

namespace scanknit {

/// Three quarters of the surface length that a pixel covers, head-on from the nearest of these camera poses; the median
/// over the mesh. Nothing when no vertex is in any picture.
[[nodiscard]] std::optional<double> fitting_texel_m(const Mesh& mesh, const CameraIntrinsics& camera,
                                                    std::span<const Pose> T_world_cameras);

}  // namespace scanknit
