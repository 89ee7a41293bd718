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

/// Opens every `every`-th of the job's frames; only those of `only`, unless it is null. Errors: those of
/// open_recording().
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_frames(const ScanJob& job, const SequenceRanges* only = nullptr,
                                                               std::size_t every = 1);

/// Reads these frames again from the recording. `job` and `only` outlive the archive.
[[nodiscard]] FrameArchive archive_of(const ScanJob& job, const SequenceRanges* only = nullptr);

}  // namespace scanknit
