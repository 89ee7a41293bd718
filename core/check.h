// SCANKNIT_CHECK: aborts the program when one of its own invariants is broken. Never used for input from outside (see
// result.h).
#pragma once

namespace scanknit {

/// Prints `condition` and the place to stderr and aborts.
[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace scanknit

#define SCANKNIT_CHECK(condition) \
  ((condition) ? static_cast<void>(0) : ::scanknit::check_failed(#condition, __FILE__, __LINE__))
