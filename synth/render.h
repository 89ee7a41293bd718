// Renders a synthetic scene as an ideal depth and colour camera sees it.
#pragma once

#include "core/camera.h"
#include "core/image.h"
#include "synth/scene/scene.h"
#include "synth/view_camera.h"

namespace scanknit {

/// All pictures have the camera's size. Depth 0: no surface within range.
struct RenderedView {
  DepthImage depth_m;               ///< exact z-depth at the pixel's centre, rounded to float
  Image<float> cos_incidence;       ///< cosine of the angle between the ray and the surface normal, 0 where no depth
  ColourImage colour;               ///< black where no depth
  Image<SurfaceMaterial> material;  ///< meaningless where no depth
};

/// The renderer sees no surface farther than this along the ray.
inline constexpr double kRenderRange_m = 40;

/// The same bits for any number of threads. `intrinsics` is valid and has a positive fx and fy.
[[nodiscard]] RenderedView render(const SyntheticScene& scene, const CameraIntrinsics& intrinsics,
                                  const Pose& T_world_camera);
/// The same with a lens and a rolling shutter. Depth is along the optical axis that the row's pose has.
[[nodiscard]] RenderedView render(const SyntheticScene& scene, const ViewCamera& camera);

/// Merges two views of one camera: each pixel of `view` becomes the nearer of the two.
void put_in_front(const RenderedView& other, RenderedView& view);

}  // namespace scanknit
