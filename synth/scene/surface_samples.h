// Truth points: a uniform sample of a scene's surface, with the number of frames that see each point.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "synth/render.h"
#include "synth/scene/scene.h"
#include "synth/view_camera.h"

namespace scanknit {

/// A surface point of a scene, and the number of frames that see it.
struct TruthPoint {
  Eigen::Vector3f position_m;
  Eigen::Vector3f normal;
  std::uint32_t views = 0;
};

/// `count` points, uniform by area; deterministic for a seed, with any number of threads.
[[nodiscard]] std::vector<TruthPoint> sample_surface(const SyntheticScene& scene, std::size_t count,
                                                     std::uint64_t seed);

/// Adds one view to every point that this picture sees: inside the picture, facing the camera (within 80 degrees), and
/// not behind the exact depth of its pixel.
void count_views(const RenderedView& view, const ViewCamera& camera, std::vector<TruthPoint>& points);

}  // namespace scanknit
