#include "acquire/replay/recording.h"

#include <algorithm>

namespace scanknit {
namespace {

/// The time from each stamp to the next; nothing: the next is not later, or does not fit 64 bits.
std::vector<std::optional<std::int64_t>> steps_ns(const std::vector<std::int64_t>& stamps_ns) {
  std::vector<std::optional<std::int64_t>> steps;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i) {
    std::int64_t step = 0;
    const bool fits = !__builtin_sub_overflow(stamps_ns[i], stamps_ns[i - 1], &step);
    steps.push_back(fits && step > 0 ? std::optional(step) : std::nullopt);
  }
  return steps;
}

/// The median of the steps that are known; a thirtieth of a second where none is.
std::int64_t usual_step_ns(const std::vector<std::optional<std::int64_t>>& steps) {
  std::vector<std::int64_t> known;
  for (const auto& step : steps) {
    if (step) known.push_back(*step);
  }
  if (known.empty()) return 33'333'333;
  const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
  std::nth_element(known.begin(), middle, known.end());
  return *middle;
}

}  // namespace

std::size_t make_times_ascend(std::vector<FrameEntry>& entries) {
  std::vector<FrameEntry*> timed;
  std::vector<std::int64_t> stamps_ns;
  for (FrameEntry& entry : entries) {
    if (!entry.timestamp_ns) continue;
    timed.push_back(&entry);
    stamps_ns.push_back(*entry.timestamp_ns);
  }
  const auto steps = steps_ns(stamps_ns);
  const auto jumps = static_cast<std::size_t>(std::count(steps.begin(), steps.end(), std::nullopt));
  if (jumps == 0) return 0;
  const std::int64_t usual_ns = usual_step_ns(steps);
  std::int64_t time_ns = stamps_ns.front();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (__builtin_add_overflow(time_ns, steps[i].value_or(usual_ns), &time_ns)) {
      for (FrameEntry* entry : timed) entry->timestamp_ns.reset();
      return jumps;
    }
    timed[i + 1]->timestamp_ns = time_ns;
  }
  return jumps;
}

}  // namespace scanknit
