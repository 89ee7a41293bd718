// Options of turntables, for `run` and `synth`.
#pragma once

#include "app/commands.h"

namespace CLI {
class App;
}

namespace scanknit {

/// `run` outlives the command.
void add_turntable_options(CLI::App& command, RunArguments& run);

/// `synth` outlives the command.
void add_rig_options(CLI::App& command, SynthArguments& synth);

}  // namespace scanknit
