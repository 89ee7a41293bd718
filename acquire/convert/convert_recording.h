// From one kind of recording to another.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquire/frame_source.h"
#include "core/result.h"

namespace scanknit {

enum class ConvertTarget { kMcap, kTum, kOpen3d, kSevenScenes, kFakenect };

struct ConvertSummary {
  std::size_t frames = 0;   ///< written
  std::size_t dropped = 0;  ///< could not be read, or had no place in the target
  std::size_t colour = 0;   ///< of the frames, with colour
  std::size_t poses = 0;    ///< of the frames, with a pose
  std::vector<std::string> warnings;
  bool was_stopped = false;
};

using ConvertProgress = std::function<void(std::size_t done)>;

/// Writes what `source` yields (opened with PoseMode::kTrack: nothing is dropped for want of a pose) to `output`, a
/// file for kMcap, else a folder that is new or empty. Depth keeps its raw units; colour files are copied byte by byte
/// where the target can hold them. Where the target cannot hold a colour camera of its own, colour is resampled into
/// the depth picture. The MCAP file appears when it is complete; a folder is as it was after an error. Errors: the
/// source's; kInput (no frame that could be read); kOutput.
[[nodiscard]] Result<ConvertSummary> convert_recording(FrameSource& source, ConvertTarget target,
                                                       const std::filesystem::path& output,
                                                       const ConvertProgress& progress = {}, std::stop_token stop = {});

}  // namespace scanknit
