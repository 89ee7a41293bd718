// Recordings of Azure Kinect's recorder (.mkv), which Orbbec's Femto cameras write, too: Matroska with depth, colour,
// infrared and the calibration. Depth is in the file as the device's software computed it. Private to the room.
#pragma once

#include <filesystem>
#include <memory>

#include "acquire/acquire_config.h"
#include "acquire/mcap/random_access.h"
#include "acquire/replay/recording.h"
#include "core/result.h"

namespace scanknit {

/// True if the file's first bytes are a Matroska file's.
[[nodiscard]] bool fits_azure_mkv(const RandomAccess& file);

/// Lists its frames; `path` is for messages. Errors (kInput) name it: there is no depth, or its camera is not known.
[[nodiscard]] Result<Recording> index_azure_mkv(std::unique_ptr<RandomAccess> file, const std::filesystem::path& path,
                                                const AcquireConfig& config);

}  // namespace scanknit
