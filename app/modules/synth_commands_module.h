// What libscanknit_synth_commands.so gives: the commands that need synth/, calibrate/ or measure/, which no scan needs.
#pragma once

#include "app/calibrate/calibrate_arguments.h"
#include "app/commands.h"

namespace scanknit {

/// Each is the function of that name in commands.h or calibrate_arguments.h, with no more threads than
/// CommonArguments::threads.
struct SynthCommandsModule {
  static constexpr const char* kName = "synth_commands";

  int (*synth)(const SynthArguments&, const CommonArguments&);
  int (*distance)(const DistanceArguments&, const CommonArguments&);
  int (*measure)(const MeasureArguments&, const CommonArguments&);
  int (*calibrate_target)(const CalibrateTargetArguments&, const CommonArguments&);
  int (*calibrate_camera)(const CalibrateCameraArguments&, const CommonArguments&);
  int (*calibrate_rig)(const CalibrateRigArguments&, const CommonArguments&);
};

}  // namespace scanknit
