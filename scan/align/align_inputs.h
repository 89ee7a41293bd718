// What `align` brings together: each input with its model for registration, and what is fused in the end.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/axes.h"
#include "core/range_scan.h"
#include "core/result.h"
#include "fusion/align/align_scans.h"
#include "scan/align/align_request.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"
#include "scan/trajectory.h"

namespace scanknit {

enum class AlignKind { kRange, kRecording, kMesh, kCloud };

/// "range scan", "recording", "mesh", "point cloud".
[[nodiscard]] const char* to_string(AlignKind kind);

struct AlignInput {
  std::string name;            ///< of the file, for people
  std::filesystem::path path;  ///< that was read
  AlignKind kind = AlignKind::kRange;
  UpAxis world_up = UpAxis::kY;
  std::optional<Pose> T_world_scan = {};  ///< from a file that says where its scans are (.conf, PTX)
  double noise_m = 0;                     ///< of a range scan
  PosesBySequence T_scan_camera = {};     ///< of a recording's frames that were fused
  std::vector<Rgb8> colours = {};         ///< of `model.all`; empty: none
  /// Its grids or frames can be fused; meshes and point clouds are brought to their place only.
  [[nodiscard]] bool is_fusable() const { return kind == AlignKind::kRange || kind == AlignKind::kRecording; }
};

/// Inputs and models, both of one length.
struct AlignInputs {
  std::vector<AlignInput> inputs;
  std::vector<ScanModel> models;
  std::string world = "the frame of scan 1";  ///< in which the poses are, for people
  FrameCounts frames;                         ///< of recordings; a range scan counts as a frame
};

/// Reads everything. A recording is fused for its model, as scan_recording() would. A scan that a .conf names but that
/// is not there is warned of. `inputs` has what was read, also after an error. Errors (kInput): unreadable, or nothing
/// at all.
[[nodiscard]] Result<void> load_align_inputs(const std::vector<std::filesystem::path>& paths, const ScanConfig& config,
                                             ScanSession& session, AlignInputs& inputs);

/// Scans are named by their number, from 1, or by their file. What says nothing or contradicts itself is told in
/// `warnings`. Errors (kInput): a line that is none of a pose, a scan that is not there.
[[nodiscard]] Result<AlignPriors> load_align_priors(const KnownPlaces& known, const AlignInputs& inputs,
                                                    const Limits& limits, std::vector<std::string>& warnings);

/// Poses a kilometre and more from the origin (georeferenced ones) are moved near it, all by the same whole number of
/// hundreds of metres: positions of a mesh are 32-bit. Returns what was taken from them, or zero.
[[nodiscard]] Eigen::Vector3d move_near_origin(AlignPriors& priors);

}  // namespace scanknit
