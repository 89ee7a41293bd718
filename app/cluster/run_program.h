// run_program: another program of this machine, run to its end.
#pragma once

#include <string>
#include <vector>

#include "core/result.h"

namespace scanknit {

struct ProgramEnd {
  int code = 0;  ///< its exit code; 128 + signal when a signal ended it
  std::string out, err;
};

/// Runs the program words[0], looked for in PATH, with the other words as arguments and nothing on its stdin. Errors
/// (kInternal): it cannot be started.
[[nodiscard]] Result<ProgramEnd> run_program(const std::vector<std::string>& words);

}  // namespace scanknit
