// The frames of a job's recording.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "acquire/frame_source.h"
#include "core/frame_timing.h"
#include "core/result.h"
#include "scan/frames/frame_archive.h"
#include "scan/frames/sequence_ranges.h"
#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Opens the job's recording, or those of its rig, with `config` in the place of its own. Errors: those of
/// open_recording() and open_rig().
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_recorded(const ScanJob& job, const AcquireConfig& config);

/// Opens every `every`-th of the job's frames; only those of `only`, unless it is null. Errors: those of
/// open_recorded().
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_frames(const ScanJob& job, const SequenceRanges* only = nullptr,
                                                               std::size_t every = 1);

/// A job's recording, and what its configuration left to the sensor.
struct OpenedRecording {
  std::unique_ptr<FrameSource> source;
  std::optional<FrameTiming> possible_timing;  ///< apply_sensor()
};

/// Opens the job's frames for the first time: warns of faults of the recording, and completes the job's configuration.
/// Errors: those of open_recorded().
[[nodiscard]] Result<OpenedRecording> open_first(ScanJob& job, ScanSession& session);

/// Reads these frames again from the recording. `job` and `only` outlive the archive.
[[nodiscard]] FrameArchive archive_of(const ScanJob& job, const SequenceRanges* only = nullptr);

}  // namespace scanknit
