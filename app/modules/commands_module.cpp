#include "app/modules/commands_module.h"

#include "app/modules/with_threads.h"
#include "core/system/module.h"
#include "core/version.h"

namespace scanknit {
namespace {

constexpr CommandsModule kCommands = {
    .run = with_threads<run_command>,
    .capture = with_threads<capture_command>,
    .view = with_threads<view_command>,
    .report = with_threads<report_command>,
    .record = with_threads<record_command>,
    .extract = with_threads<extract_command>,
    .align = with_threads<align_command>,
    .plan = with_threads<plan_command>,
    .work = with_threads<work_command>,
    .join = with_threads<join_command>,
    .status = with_threads<status_command>,
    .cluster = with_threads<cluster_command>,
    .devices = with_threads<devices_command>,
    .doctor = with_threads<doctor_command>,
    .udev_rules = with_threads<udev_rules_command>,
    .describe_shape = describe_shape,
};

constexpr ModuleEntry kEntry = {kVersion, &kCommands};

}  // namespace
}  // namespace scanknit

extern "C" const scanknit::ModuleEntry* scanknit_module() {
  return &scanknit::kEntry;
}
