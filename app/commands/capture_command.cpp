// capture: scans with a scanner that is plugged in, and writes a mesh and a recording.
#include "app/commands/mesh_command.h"
#include "scan/scan.h"

namespace scanknit {
namespace {

/// The recording next to the mesh: OUT/recording.mcap, or NAME.mcap for one mesh file.
std::filesystem::path default_recording(const std::filesystem::path& output, const ScanFiles& files) {
  const bool is_one_file = !files.meshes.empty() && files.meshes.front() == output;
  return is_one_file ? std::filesystem::path(output).replace_extension(".mcap") : output / "recording.mcap";
}

}  // namespace

MeshCommand mesh_command_of(const CaptureArguments& arguments, const ConfigSources& config) {
  MeshCommand command{
      .input = arguments.scanner.device, .config = with_run_defaults(config), .outputs = arguments.outputs};
  command.view = arguments.view;
  command.is_capture = true;
  command.scan = [&](const ScanJob& job, const LoadedConfig&, ScanObserver& observer, const std::stop_token& stop) {
    LiveScanRequest request{arguments.scanner, std::nullopt};
    if (arguments.wants_recording) {
      request.recording = arguments.recording.value_or(default_recording(arguments.outputs.output, job.files));
    }
    return scan_live(job, request, observer, stop);
  };
  return command;
}

}  // namespace scanknit
