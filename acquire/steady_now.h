// This computer's steady clock, as RawFrame::host_ns has it.
#pragma once

#include <chrono>
#include <cstdint>

namespace scanknit {

[[nodiscard]] inline std::int64_t steady_now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

}  // namespace scanknit
