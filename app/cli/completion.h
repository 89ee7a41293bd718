// Completion of the command line, as scripts for the shells.
#pragma once

#include <string>

#include "app/cli/command_tree.h"

namespace scanknit {

/// What to `source`, or to put where the shell looks for it. `program` is the whole program's description.
[[nodiscard]] std::string bash_completion(const CommandDescription& program);
[[nodiscard]] std::string zsh_completion(const CommandDescription& program);
[[nodiscard]] std::string fish_completion(const CommandDescription& program);

}  // namespace scanknit
