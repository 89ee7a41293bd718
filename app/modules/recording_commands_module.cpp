#include "app/modules/recording_commands_module.h"

#include "app/modules/with_threads.h"
#include "core/system/module.h"
#include "core/version.h"

namespace scanknit {
namespace {

constexpr RecordingCommandsModule kCommands = {
    .convert = with_threads<convert_command>,
    .repair = with_threads<repair_command>,
    .info = with_threads<info_command>,
};

constexpr ModuleEntry kEntry = {kVersion, &kCommands};

}  // namespace
}  // namespace scanknit

extern "C" const scanknit::ModuleEntry* scanknit_module() {
  return &scanknit::kEntry;
}
