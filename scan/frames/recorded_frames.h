// The frames of a job's recording.
#pragma once

#include <cstddef>
#include <memory>

#include "acquire/frame_source.h"
#include "core/result.h"
#include "scan/frames/frame_archive.h"
#include "scan/scan_job.h"

namespace scanknit {

/// Every `every`-th of the job's frames. Errors: open_recording().
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_frames(const ScanJob& job, std::size_t every = 1);

/// Reads them again from the recording. `job` outlives it.
[[nodiscard]] FrameArchive archive_of(const ScanJob& job);

}  // namespace scanknit
