// The inputs of `align`: each with its model for registration, and with what is fused in the end.
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
#include "scan/align/align.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

struct AlignInput {
  std::string name;            ///< of the file, for messages
  std::filesystem::path path;  ///< the file that was read
  AlignKind kind = AlignKind::kRange;
  UpAxis world_up = UpAxis::kY;
  std::optional<Pose> T_world_scan = {};  ///< from a file that says where its scans are (.conf, PTX)
  double noise_m = 0;                     ///< of a range scan
  ScanConfig config = {};                 ///< of a recording: with its own sensor's range and noise
  Trajectory trajectory = {};             ///< of the frames of a recording that were fused, in its scan
  std::vector<Rgb8> colours = {};         ///< of `model.all`; empty: none
  /// True when its grids or frames can be fused. Meshes and point clouds only get a pose.
  [[nodiscard]] bool is_fusable() const { return kind == AlignKind::kRange || kind == AlignKind::kRecording; }
};

/// Inputs and their models; both lists have the same length. After an error, what was read before it.
struct AlignInputs {
  Result<void> outcome;
  std::vector<AlignInput> inputs;
  std::vector<ScanModel> models;
  std::string world = "the frame of scan 1";  ///< the frame of the poses, for messages
  FrameCounts frames;                         ///< of recordings; a range scan counts as a frame
};

/// Reads all inputs. Tracks and fuses each recording, to get its model; closes no loops. Warns of each scan that a
/// .conf names and that does not exist. `outcome` (kInput): a file is unreadable, or there is nothing to read.
[[nodiscard]] AlignInputs load_align_inputs(const std::vector<std::filesystem::path>& paths, const ScanConfig& config,
                                            ScanSession& session);

struct LoadedPriors {
  AlignPriors priors;
  std::vector<std::string> warnings;  ///< of entries that are useless or that contradict each other
};

/// Reads the poses and markers that are known. A scan is named by its number, from 1, or by its file. Errors (kInput):
/// a line that is not a pose, a scan that does not exist.
[[nodiscard]] Result<LoadedPriors> load_align_priors(const KnownPlaces& known, const AlignInputs& inputs,
                                                     const Limits& limits);

/// What to subtract from the poses when they are a kilometre or more from the origin (georeferenced ones), so that they
/// lie near it: a multiple of 100 m, because positions of a mesh are 32-bit floats. Else zero.
[[nodiscard]] Eigen::Vector3d offset_from_origin(const AlignPriors& priors);

}  // namespace scanknit
