// Writes a synthetic scan to disk as a recording in a common layout.
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
  std::size_t frames = 0;          ///< frames written
  std::size_t visible_points = 0;  ///< truth points that at least config.min_views frames see
  std::size_t truth_points = 0;    ///< number sampled on the whole surface
  bool was_stopped = false;        ///< a stop request came before the last frame; the shorter recording is complete
};

/// Called after each frame with the numbers of frames done and to do.
using SynthProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Open3D's layout: depth/NNNNNN.png (16 bit, config.depth_scale units per metre, 0 = no return), color/NNNNNN.png or
/// .jpg, if asked for masks/NNNNNN.png, trajectory.log (camera to world, 17 digits), camera_intrinsic.json (with one
/// more key than Open3D's own: "depth_scale"), with a sensor timestamps.txt (seconds of each frame), and the truth
/// files of truth_files.h. Makes the folder if it does not exist. Replaces an older synthetic recording in it; refuses
/// any other folder that has a depth/ folder. For a scene on a turntable, true_poses.log (camera to object) takes the
/// place of trajectory.log, and angles.txt has the angle of each frame in degrees, as an encoder would report it.
/// Errors: kConfig (see validate), kOutput.
[[nodiscard]] Result<SynthSummary> write_synthetic_recording(const SyntheticScene& scene, const SynthConfig& config,
                                                             const std::filesystem::path& folder,
                                                             const SynthProgress& progress = {},
                                                             std::stop_token stop = {});

}  // namespace scanknit
