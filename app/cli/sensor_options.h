// The options of `synth` for sensors, paths and people.
#pragma once

#include <CLI/App.hpp>

#include "app/cli/command_line.h"

namespace scanknit {

/// `noise`: the option that cannot be combined with a sensor.
void add_sensor_options(CLI::App& command, CommandLine& line, CLI::Option* noise);

}  // namespace scanknit
