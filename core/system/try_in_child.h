// try_in_child(): first try in a child process what a damaged file may crash or make grow without bound.
#pragma once

#include <cstddef>
#include <functional>

#include "core/result.h"

namespace scanknit {

struct ChildLimits {
  std::size_t memory_bytes = 0;  ///< that `work` may allocate, beside what the process has already
  double seconds = 0;            ///< of processor time; rounded up
  double stall_seconds = 10;     ///< in which the child may sleep without any progress
};

/// Runs `work` in a fork of this process and returns its result. What `work` makes is lost with the child; this process
/// stays as it is whatever happens there. `work` must not wait for other threads: the child has none. Libraries may all
/// the same, for a lock that a thread held when this process forked; such a child is given up and another one tried.
/// Errors: those of `work`; kInput when it crashes or exceeds a limit; kBudget when the system has no memory or process
/// for a child, or three of them stall.
[[nodiscard]] Result<void> try_in_child(const std::function<Result<void>()>& work, const ChildLimits& limits);

}  // namespace scanknit
