// Raycasting: renders the volume as a camera sees it.
#pragma once

#include "core/camera.h"
#include "core/pose.h"
#include "fusion/register/model_view.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// Follows the ray of each pixel to the first place where the trilinearly interpolated signed distance falls through
/// zero, from observed free space into observed matter. Never interpolates unknown voxels (weight 0), so that it
/// invents no surface between them. A ray that enters matter from behind gives no surface. Normals are the field's
/// gradient. The same bits for any number of threads. An empty volume gives an empty view of the right size.
[[nodiscard]] ModelView raycast(const TsdfVolume& volume, const CameraIntrinsics& intrinsics,
                                const Pose& T_world_camera);

}  // namespace scanknit
