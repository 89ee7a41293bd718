#include "app/commands/commands_module.h"

#include <tbb/global_control.h>

#include <optional>
#include <tuple>

#include "core/system/module.h"
#include "core/version.h"

namespace scanknit {
namespace {

/// `kCommand` with no more threads than were asked for. CommonArguments are the last of its arguments.
template <auto kCommand, typename... Arguments>
int with_threads(const Arguments&... arguments) {
  const CommonArguments& common = std::get<sizeof...(Arguments) - 1>(std::tie(arguments...));
  std::optional<tbb::global_control> limit;
  if (common.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, common.threads);
  return kCommand(arguments...);
}

constexpr CommandsModule kCommands = {
    .run = with_threads<run_command>,
    .capture = with_threads<capture_command>,
    .view = with_threads<view_command>,
    .report = with_threads<report_command>,
    .record = with_threads<record_command>,
    .extract = with_threads<extract_command>,
    .align = with_threads<align_command>,
    .synth = with_threads<synth_command>,
    .convert = with_threads<convert_command>,
    .repair = with_threads<repair_command>,
    .calibrate_target = with_threads<calibrate_target_command>,
    .calibrate_camera = with_threads<calibrate_camera_command>,
    .info = with_threads<info_command>,
    .distance = with_threads<distance_command>,
    .devices = with_threads<devices_command>,
    .doctor = with_threads<doctor_command>,
    .udev_rules = with_threads<udev_rules_command>,
};

constexpr ModuleEntry kEntry = {kVersion, &kCommands};

}  // namespace
}  // namespace scanknit

extern "C" const scanknit::ModuleEntry* scanknit_module() {
  return &scanknit::kEntry;
}
