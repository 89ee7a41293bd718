// Truth files: the exact surface and poses of a synthetic recording, to measure the error of a mesh.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "core/result.h"
#include "synth/scene/scene.h"
#include "synth/scene/surface_samples.h"
#include "synth/synth_config.h"

namespace scanknit {

inline constexpr const char* kGroundTruthFile = "ground_truth.json";
inline constexpr const char* kGroundTruthMeshFile = "ground_truth.ply";
inline constexpr const char* kVisiblePointsFile = "visible_points.ply";

/// Writes ground_truth.json and visible_points.ply, and ground_truth.ply if the scene was made from a mesh.
[[nodiscard]] Result<void> write_truth(const SyntheticScene& scene, const SynthConfig& config, std::size_t frames,
                                       const std::vector<TruthPoint>& visible, const std::filesystem::path& folder);

inline constexpr const char* kPosesFile = "trajectory.log";
inline constexpr const char* kTruePosesFile = "true_poses.log";  ///< a name that no reader takes for the recording's
                                                                 ///< poses
inline constexpr const char* kEncoderFile = "angles.txt";
inline constexpr const char* kTimesFile = "timestamps.txt";

/// The true poses of a recording, one for each frame: from true_poses.log if it exists, else from trajectory.log.
/// Errors (kInput): neither exists, or the file is malformed.
[[nodiscard]] Result<std::vector<Pose>> read_true_poses(const std::filesystem::path& folder, const Limits& limits = {});

struct Truth {
  std::unique_ptr<SyntheticScene> scene;
  std::vector<TruthPoint> visible;
};

/// Reads what write_truth wrote. Errors (kInput): a file missing, malformed, truncated or beyond `limits`; a scene that
/// this version does not have, or that has changed since the recording was made.
[[nodiscard]] Result<Truth> read_truth(const std::filesystem::path& folder, const Limits& limits = {});

}  // namespace scanknit
