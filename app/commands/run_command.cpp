#include "app/commands/mesh_command.h"
#include "scan/scan.h"

namespace scanknit {

MeshCommand mesh_command_of(const RunArguments& arguments, const ConfigSources& config) {
  MeshCommand command{.input = arguments.recording, .config = with_run_defaults(config), .outputs = arguments.outputs};
  command.view = arguments.view;
  command.configure = [&](ScanConfig& scan) {
    scan.acquire.from = arguments.from;
    scan.acquire.every = arguments.every;
    if (arguments.to) scan.acquire.to = *arguments.to;
    return Result<void>();
  };
  command.complete = [&](ScanJob& job) {
    job.pace = arguments.pace;
    job.angles = arguments.angles;
    job.cut_recording = arguments.cut_recording;
  };
  command.scan = [](const ScanJob& job, const LoadedConfig&, ScanObserver& observer, const std::stop_token& stop) {
    return scan_recording(job, observer, stop);
  };
  return command;
}

}  // namespace scanknit
