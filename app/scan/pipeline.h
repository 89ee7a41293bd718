// The main job: a recording becomes a mesh.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>

#include "acquire/frame_source.h"
#include "acquire/replay/paced_source.h"
#include "app/config/config.h"
#include "app/scan/outputs.h"
#include "app/scan/second_look.h"
#include "app/scan/sequence_ranges.h"
#include "app/terminal/console.h"
#include "core/result.h"
#include "export/report/report.h"

namespace scanknit {

class FrameIntake;
class ScanView;
class TurntableScan;

struct Job {
  std::filesystem::path input;
  Config config;
  Outputs outputs;
  Pace pace = Pace::kFast;
  std::optional<std::filesystem::path> angles = std::nullopt;         ///< of a turntable, see known_angles.h
  std::optional<std::filesystem::path> cut_recording = std::nullopt;  ///< of a turntable: its frames are written here
  std::optional<SequenceRanges> frames = std::nullopt;                ///< of `input`; nothing: all that are selected
};

/// Every `every`-th of the job's frames. Errors: open_recording().
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_frames(const Job& job, std::size_t every = 1);

/// Recording -> volume -> mesh -> files, the report excepted, which is the caller's. `report` tells what was done, also
/// after an error. A stop request, or those who look on through `view`, end the fusing; what has been fused becomes the
/// mesh. Then loops are closed, when there are any. Errors: kOutput before any work; kInput without a usable frame;
/// kBudget; kMesh for an empty mesh.
[[nodiscard]] Result<void> run_pipeline(const Job& job, std::stop_token stop, Console& console, RunReport& report,
                                        ScanView& view);

/// The same from frames that are there already, or are yet to come from a scanner; the outputs have been checked. With
/// a `table`, the mesh of the tracked frames is written first, unless most were lost, and then that of the refined
/// turntable in its place.
[[nodiscard]] Result<void> mesh_frames(FrameIntake& intake, const Job& job, Console& console, RunReport& report,
                                       ScanView& view, const SecondLook& again, TurntableScan* table = nullptr);

/// The frames of a turntable become a mesh that takes the place of the one which is there; the report then tells of it,
/// and of the frames that were `left_out` of the job's. False: it is no turntable, and all is left as it is but for
/// `report.turntable`. Errors: as run_pipeline.
[[nodiscard]] Result<bool> mesh_recorded_turntable(const Job& job, const RunReport::Frames& left_out,
                                                   std::stop_token stop, Console& console, RunReport& report,
                                                   ScanView& view);

}  // namespace scanknit
