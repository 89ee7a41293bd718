// The options of `calibrate target`, `calibrate camera` and `calibrate rig`.
#pragma once

#include <CLI/App.hpp>

#include "app/cli/command_line.h"

namespace scanknit {

void add_calibrate_target_options(CLI::App& command, CommandLine& line);
void add_calibrate_camera_options(CLI::App& command, CalibrateCameraArguments& camera);
void add_calibrate_rig_options(CLI::App& command, CalibrateRigArguments& rig);

}  // namespace scanknit
