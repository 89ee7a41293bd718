// The frames of a job's recording.
#pragma once

#include <cstddef>
#include <memory>

#include "acquire/frame_source.h"
#include "core/result.h"
#include "scan/frames/frame_archive.h"
#include "scan/scan_job.h"

namespace scanknit {

/// Opens every `every`-th of the job's frames. Errors: those of open_recording().
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_frames(const ScanJob& job, std::size_t every = 1);

/// Reads the job's frames again from the recording. `job` outlives the archive.
[[nodiscard]] FrameArchive archive_of(const ScanJob& job);

}  // namespace scanknit
