#include "app/commands/mesh_command.h"
#include "app/terminal/pace_control.h"
#include "scan/scan.h"

namespace scanknit {

int run_command(const RunArguments& arguments, const CommonArguments& common) {
  MeshCommand command{
      .input = arguments.recording, .config = with_run_defaults(common.config), .outputs = arguments.outputs};
  command.view = arguments.view;
  command.configure = [&](ScanConfig& config) {
    config.acquire.from = arguments.from;
    config.acquire.every = arguments.every;
    if (arguments.to) config.acquire.to = *arguments.to;
    return Result<void>();
  };
  command.complete = [&](ScanJob& job) {
    job.pace = arguments.pace;
    job.pace_control = terminal_pace_control;
    job.angles = arguments.angles;
    job.cut_recording = arguments.cut_recording;
  };
  command.scan = scan_recording;
  return run_mesh_command(command, common);
}

}  // namespace scanknit
