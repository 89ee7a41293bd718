#include "scan/align/align.h"

#include "app/commands/mesh_command.h"

namespace scanknit {

MeshCommand mesh_command_of(const AlignArguments& arguments, const ConfigSources& config) {
  MeshCommand command{
      .input = arguments.request.inputs.front(), .config = with_run_defaults(config), .outputs = arguments.outputs};
  command.configure = [](const ScanConfig& scan) { return refuse_texture(scan, "align"); };
  command.scan = [&](const ScanJob& job, const LoadedConfig& loaded, ScanObserver& observer,
                     const std::stop_token& stop) {
    AlignRequest request = arguments.request;
    request.has_voxel_size = loaded.gives("fusion.voxel_size");
    return align_and_mesh(job, request, observer, stop);
  };
  return command;
}

}  // namespace scanknit
