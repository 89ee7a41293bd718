// Truth files: what a synthetic recording keeps beside its frames so that a mesh of it can be judged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "acquire/synthetic/scene.h"
#include "acquire/synthetic/surface_samples.h"
#include "acquire/synthetic/synth_config.h"
#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

inline constexpr const char* kGroundTruthFile = "ground_truth.json";
inline constexpr const char* kGroundTruthMeshFile = "ground_truth.ply";
inline constexpr const char* kVisiblePointsFile = "visible_points.ply";

/// Writes ground_truth.json, visible_points.ply, and ground_truth.ply for a scene made from a mesh.
[[nodiscard]] Result<void> write_truth(const SyntheticScene& scene, const SynthConfig& config, std::size_t frames,
                                       const std::vector<TruthPoint>& visible, const std::filesystem::path& folder);

struct Truth {
  std::unique_ptr<SyntheticScene> scene;
  std::vector<TruthPoint> visible;
};

/// Reads what write_truth wrote. Errors (kInput): a file missing, malformed, truncated or beyond `limits`; a scene that
/// this version does not know, or draws differently than when the recording was made.
[[nodiscard]] Result<Truth> read_truth(const std::filesystem::path& folder, const Limits& limits = {});

}  // namespace scanknit
