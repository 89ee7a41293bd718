// Converts a recording to another layout.
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

enum class ConvertTarget { kMcap, kTum, kOpen3d, kSevenScenes, kFakenect, kNerfstudio, kColmap, kRos2 };

/// Is the output one file? Else it is a folder.
[[nodiscard]] constexpr bool is_one_file(ConvertTarget target) {
  return target == ConvertTarget::kMcap || target == ConvertTarget::kRos2;
}

struct ConvertSummary {
  std::size_t frames = 0;   ///< frames written
  std::size_t dropped = 0;  ///< frames that could not be read, or that the target cannot hold
  std::size_t colour = 0;   ///< frames with colour
  std::size_t poses = 0;    ///< frames with a pose
  std::vector<std::string> warnings;
  bool was_stopped = false;
};

using ConvertProgress = std::function<void(std::size_t done)>;

/// Writes the frames of `source` to `output`: a file if is_one_file(target), else a folder that is new or empty. Open
/// `source` with PoseMode::kTrack, so that frames without a pose are not dropped. Depth keeps its raw units; colour
/// files are copied byte by byte if the target can hold them. If the target cannot hold a separate colour camera,
/// resamples colour into the depth picture. The file appears when it is complete; after an error, a folder is as
/// before. Errors: those of the source; kInput (no frame could be read); kOutput.
[[nodiscard]] Result<ConvertSummary> convert_recording(FrameSource& source, ConvertTarget target,
                                                       const std::filesystem::path& output,
                                                       const ConvertProgress& progress = {}, std::stop_token stop = {});

}  // namespace scanknit
