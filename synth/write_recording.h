// Writing a synthetic scan to disk as a recording that anyone can read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <stop_token>

#include "core/result.h"
#include "synth/scene/scene.h"
#include "synth/synth_config.h"

namespace scanknit {

struct SynthSummary {
  std::size_t frames = 0;          ///< written
  std::size_t visible_points = 0;  ///< truth points that at least config.min_views frames see
  std::size_t truth_points = 0;    ///< sampled on the whole surface
  bool was_stopped = false;        ///< a stop request came before the last frame; what there is is a whole recording
};

/// Called after each frame with the number done and the number to do.
using SynthProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Open3D's layout: depth/NNNNNN.png (16 bit, config.depth_scale units per metre, 0 = no return), color/NNNNNN.png or
/// .jpg, trajectory.log (camera to world, 17 digits), camera_intrinsic.json (with one more key than Open3D's own:
/// "depth_scale"), and the truth files of truth_files.h. The folder is made when it is not there. An older synthetic
/// recording in it is replaced; anything else that already has a depth/ folder is left alone and refused.
/// Of a scene on a turntable there is no trajectory.log: true_poses.log holds the same (camera to object), and
/// angles.txt the angle of each frame in degrees, as an encoder would give it.
/// Errors: kConfig (see validate), kOutput.
[[nodiscard]] Result<SynthSummary> write_synthetic_recording(const SyntheticScene& scene, const SynthConfig& config,
                                                             const std::filesystem::path& folder,
                                                             const SynthProgress& progress = {},
                                                             std::stop_token stop = {});

}  // namespace scanknit
