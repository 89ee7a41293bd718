#include "app/cli/rig_options.h"

#include <CLI/CLI.hpp>

namespace scanknit {

void add_turntable_options(CLI::App& command, RunArguments& run) {
  const std::string group = "Turntable";
  command.add_option("--angles", run.angles, "Angle of each frame in degrees, one a line")
      ->type_name("FILE")
      ->group(group);
  command
      .add_option("--cut-recording", run.cut_recording,
                  "Write the frames here, cut and with their poses, for `align` and other programs")
      ->type_name("DIR")
      ->group(group);
}

void add_rig_options(CLI::App& command, SynthArguments& synth) {
  const std::string group = "Turntable";
  auto* table =
      command
          .add_flag("--turntable", synth.is_on_turntable,
                    "The scanner stands still before a wall and the scene turns on a table; no poses are kept")
          ->group(group);
  command.add_option("--turns", synth.turns, "Turns of the table: 1, 0.97, 2")
      ->check(CLI::Range(0.001, 100.0))
      ->needs(table)
      ->group(group);
  command.add_option("--angle-noise", synth.angle_noise_degrees, "Deviation of each angle from a steady turn, degrees")
      ->check(CLI::Range(0.0, 11.0))
      ->needs(table)
      ->group(group);
  command.add_flag("--on-side", synth.is_on_side, "The object lies on its side")->needs(table)->group(group);
  command.add_flag("--hand", synth.has_hand, "A hand reaches in for a tenth of the time")->needs(table)->group(group);
}

}  // namespace scanknit
