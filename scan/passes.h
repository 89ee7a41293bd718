// A pass through a scan's frames, as a walk or as a turntable.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/axes.h"
#include "scan/frames/sequence_ranges.h"
#include "scan/scan_job.h"
#include "scan/scan_pass.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// What a pass made, and what another pass over the same frames starts from.
struct PassResult {
  ScanResult scan;       ///< without what ScanSession::conclude() adds
  SequenceRanges taken;  ///< FrameIntake::taken()
  FrameCounts left_out;  ///< FrameIntake::left_out()
  CropBox crop;
  bool has_given_up = false;                  ///< PassInput::limits
  std::optional<double> misfit;               ///< ScanPass::misfit()
  std::vector<std::uint64_t> fused, samples;  ///< ScanPass::fused_order(), ::sample_sequences()
};

/// Scans the frames as they come; closes loops if poses are tracked and fusion.loop_closure is on.
[[nodiscard]] PassResult scan_walk(const ScanJob& job, const PassInput& input, ScanSession& session);

/// Scans a turntable: leaves out what stands still, and finds the axis and the angles. `scan.turntable->is_refined` is
/// false if there is none, or after an error.
[[nodiscard]] PassResult scan_turntable(const ScanJob& job, const PassInput& input, ScanSession& session);

/// The result of a second pass that replaces the first one. What only the first pass has, it keeps: the scanner that
/// was found, its losses, files, and, unless the second pass looked for a turntable, the first one's turntable.
[[nodiscard]] ScanResult replacing(ScanResult first, ScanResult second);

}  // namespace scanknit
