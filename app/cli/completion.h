// Scripts that complete the command line in the shells.
#pragma once

#include <string>

#include "app/cli/command_tree.h"

namespace scanknit {

/// A script to `source`, or to put where the shell looks for completions. `program` describes the whole program.
[[nodiscard]] std::string bash_completion(const CommandDescription& program);
[[nodiscard]] std::string zsh_completion(const CommandDescription& program);
[[nodiscard]] std::string fish_completion(const CommandDescription& program);

}  // namespace scanknit
