// Repairs a truncated or damaged recording.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct RepairSummary {
  std::uint64_t messages = 0;        ///< messages kept
  std::uint64_t lost = 0;            ///< messages in chunks with a wrong checksum
  std::optional<std::string> fault;  ///< the fault of the file; nothing: it was intact
};

/// Writes every message in an intact chunk of the MCAP file `input`, with index and summary, to `output`, which may be
/// `input` itself: the old file stays until the new one is complete. Takes any MCAP file, but drops attachments and
/// metadata (our recordings have none). Errors: kInput (no MCAP file, no intact message, or `output` is `input` and is
/// still being recorded), kOutput (also when `output` is another file that exists already), kTooLittle when `stop` was
/// requested: nothing is written.
[[nodiscard]] Result<RepairSummary> repair_recording(const std::filesystem::path& input,
                                                     const std::filesystem::path& output, const Limits& limits,
                                                     std::stop_token stop = {});

}  // namespace scanknit
