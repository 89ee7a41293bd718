// Truth files: what a synthetic recording keeps beside its frames so that a mesh of it can be judged.
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

/// Writes ground_truth.json, visible_points.ply, and ground_truth.ply for a scene made from a mesh.
[[nodiscard]] Result<void> write_truth(const SyntheticScene& scene, const SynthConfig& config, std::size_t frames,
                                       const std::vector<TruthPoint>& visible, const std::filesystem::path& folder);

inline constexpr const char* kPosesFile = "trajectory.log";
inline constexpr const char* kTruePosesFile = "true_poses.log";  ///< no reader takes them for the recording's
inline constexpr const char* kEncoderFile = "angles.txt";

/// The true poses of a recording, one a frame: of true_poses.log if there is one, else of trajectory.log. Errors
/// (kInput): neither is there, or it is malformed.
[[nodiscard]] Result<std::vector<Pose>> read_true_poses(const std::filesystem::path& folder, const Limits& limits = {});

struct Truth {
  std::unique_ptr<SyntheticScene> scene;
  std::vector<TruthPoint> visible;
};

/// Reads what write_truth wrote. Errors (kInput): a file missing, malformed, truncated or beyond `limits`; a scene that
/// this version does not know, or draws differently than when the recording was made.
[[nodiscard]] Result<Truth> read_truth(const std::filesystem::path& folder, const Limits& limits = {});

}  // namespace scanknit
