#include "acquire/record/repair_recording.h"

#include <optional>
#include <span>

#include "acquire/mcap/append_file.h"
#include "acquire/mcap/mcap_reader.h"
#include "acquire/mcap/mcap_writer.h"
#include "acquire/new_recording.h"
#include "core/files/atomic_file.h"

namespace scanknit {

Result<RepairSummary> repair_recording(const std::filesystem::path& input, const std::filesystem::path& output,
                                       const Limits& limits, std::stop_token stop) {
  std::error_code ignored;
  const bool is_in_place = input == output || std::filesystem::equivalent(input, output, ignored);
  if (is_in_place && is_being_appended(input)) {
    return Error{ErrorCode::kInput, "is still being recorded; end that first, or give another -o", input.string()};
  }
  if (!is_in_place) {
    if (auto is_new = check_is_new_recording(output); !is_new) return is_new.error();
  }
  auto access = open_random_access(input);
  if (!access) return access.error();
  auto reader = McapReader::open(*std::move(access), limits);
  if (!reader) return Error{ErrorCode::kInput, reader.error().message, input.string()};
  // Where a link leads to, not in the link's place.
  const auto place = is_in_place ? std::filesystem::canonical(input, ignored) : output;
  if (auto writable = check_writable(place); !writable) return writable.error();
  auto file = AtomicFile::create(place);
  if (!file) return file.error();

  McapWriter writer([&](std::span<const std::byte> bytes) { return file->write(bytes); }, reader->schemas(),
                    reader->channels());
  if (auto begun = writer.begin(); !begun) return begun.error();
  RepairSummary summary{.fault = reader->fault()};
  std::optional<std::uint32_t> chunk;  // the chunks stay as they were
  for (const McapMessagePlace& message : reader->messages()) {
    if (stop.stop_requested()) return Error{ErrorCode::kTooLittle, "interrupted: nothing was written", output.string()};
    const auto data = reader->read(message);
    if (!data) {
      ++summary.lost;
      if (!summary.fault) summary.fault = data.error().message;
      continue;
    }
    if (chunk && *chunk != message.chunk) {
      if (auto flushed = writer.flush(); !flushed) return flushed.error();
    }
    chunk = message.chunk;
    writer.add({.channel = message.channel,
                .sequence = message.sequence,
                .log_ns = message.log_ns,
                .publish_ns = message.publish_ns,
                .data = *data});
    ++summary.messages;
  }
  if (summary.messages == 0) return Error{ErrorCode::kInput, "not one whole message is left in it", input.string()};
  if (auto finished = writer.finish(); !finished) return finished.error();
  if (auto committed = file->commit(); !committed) return committed.error();
  return summary;
}

}  // namespace scanknit
