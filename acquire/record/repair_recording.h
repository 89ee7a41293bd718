// Mending a torn recording.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct RepairSummary {
  std::uint64_t messages = 0;        ///< kept
  std::uint64_t lost = 0;            ///< seen, but in a chunk whose checksum is wrong
  std::optional<std::string> fault;  ///< what was wrong with the file; nothing: it was whole
};

/// Writes every message of the MCAP file `input` whose chunk is whole, with index and summary, to `output`, which may
/// be `input` itself: the old file stays until the new one is complete. Any MCAP file; its attachments and metadata are
/// not kept (recordings of ours have none). Errors: kInput (no MCAP file, not one whole message, or `output` is `input`
/// while it is still being recorded), kOutput (also when `output` is another file that is there already).
[[nodiscard]] Result<RepairSummary> repair_recording(const std::filesystem::path& input,
                                                     const std::filesystem::path& output, const Limits& limits);

}  // namespace scanknit
