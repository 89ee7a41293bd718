#include "app/modules/synth_commands_module.h"

#include "app/modules/with_threads.h"
#include "core/system/module.h"
#include "core/version.h"

namespace scanknit {
namespace {

constexpr SynthCommandsModule kCommands = {
    .synth = with_threads<synth_command>,
    .distance = with_threads<distance_command>,
    .measure = with_threads<measure_command>,
    .calibrate_target = with_threads<calibrate_target_command>,
    .calibrate_camera = with_threads<calibrate_camera_command>,
    .calibrate_rig = with_threads<calibrate_rig_command>,
};

constexpr ModuleEntry kEntry = {kVersion, &kCommands};

}  // namespace
}  // namespace scanknit

extern "C" const scanknit::ModuleEntry* scanknit_module() {
  return &scanknit::kEntry;
}
