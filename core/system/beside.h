// beside(): work for which there is another processor core.
#pragma once

#include <tbb/global_control.h>

#include <future>
#include <utility>

namespace scanknit {

/// False where the program may use one thread only: TBB's max_allowed_parallelism.
[[nodiscard]] inline bool may_work_beside() {
  using tbb::global_control;
  return global_control::active_value(global_control::max_allowed_parallelism) > 1;
}

/// Begins `work` on a thread of its own; if there may be none, the system has none left, or both together would take
/// too much memory (`has_room`), get() does it. The future's destructor waits for the thread.
template <typename Work>
[[nodiscard]] auto beside(Work&& work, bool has_room = true) {
  const auto where = has_room && may_work_beside() ? std::launch::async | std::launch::deferred : std::launch::deferred;
  return std::async(where, std::forward<Work>(work));
}

}  // namespace scanknit
