// How fine a texture need be.
#pragma once

#include <optional>
#include <span>

#include "core/camera.h"
#include "core/mesh.h"
#include "core/pose.h"

namespace scanknit {

/// Three quarters of what a pixel covers of the surface, seen head-on from the nearest of these poses of the camera:
/// median over the mesh. Nothing when no vertex is in any picture.
[[nodiscard]] std::optional<double> fitting_texel_m(const Mesh& mesh, const CameraIntrinsics& camera,
                                                    std::span<const Pose> T_world_cameras);

}  // namespace scanknit
