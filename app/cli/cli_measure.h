// The options of `measure` and of `distance`.
#pragma once

#include "app/cli/command_line.h"

namespace CLI {
class App;
}

namespace scanknit {

/// `line` outlives the command.
void add_distance_options(CLI::App& command, CommandLine& line);
void add_measure_options(CLI::App& command, CommandLine& line);

}  // namespace scanknit
