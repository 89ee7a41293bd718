// with_threads: a command that heeds CommonArguments::threads.
#pragma once

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <optional>
#include <tuple>

#include "app/commands.h"

namespace scanknit {

/// Gives TBB the memory that it needs to begin. If it began in OpenVDB's destructors, a lack of memory would end the
/// program at once.
inline void begin_tbb() {
  tbb::parallel_for(0, 1, [](int) {});
}

/// `kCommand` with no more threads than were asked for. CommonArguments are the last of its arguments.
template <auto kCommand, typename... Arguments>
int with_threads(const Arguments&... arguments) {
  const CommonArguments& common = std::get<sizeof...(Arguments) - 1>(std::tie(arguments...));
  std::optional<tbb::global_control> limit;
  if (common.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, common.threads);
  begin_tbb();
  return kCommand(arguments...);
}

}  // namespace scanknit
