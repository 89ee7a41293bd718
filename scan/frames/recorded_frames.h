// The frames of a job's recording.
#pragma once

#include <cstddef>
#include <memory>

#include "acquire/frame_source.h"
#include "core/result.h"
#include "scan/frames/frame_archive.h"
#include "scan/frames/sequence_ranges.h"
#include "scan/scan_job.h"

namespace scanknit {

/// Every `every`-th of the job's frames, those of `only` alone unless it is null. Errors: open_recording().
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_frames(const ScanJob& job, const SequenceRanges* only = nullptr,
                                                               std::size_t every = 1);

/// Reads them again from the recording. `job` and `only` outlive it.
[[nodiscard]] FrameArchive archive_of(const ScanJob& job, const SequenceRanges* only = nullptr);

}  // namespace scanknit
