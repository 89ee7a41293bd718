#include "scan/align/align.h"

#include "app/commands/mesh_command.h"
#include "scan/mesh/write_texture.h"

namespace scanknit {

int align_command(const AlignArguments& arguments, const CommonArguments& common) {
  MeshCommand command{.input = arguments.request.inputs.front(),
                      .config = with_run_defaults(common.config),
                      .outputs = arguments.outputs};
  command.configure = [](const ScanConfig& config) { return refuse_texture(config, "align"); };
  command.scan = [&](const ScanJob& job, ScanObserver& observer, const std::stop_token& stop) {
    AlignRequest request = arguments.request;
    request.has_voxel_size = job.gives("fusion.voxel_size");
    return align_and_mesh(job, request, observer, stop);
  };
  return run_mesh_command(command, common);
}

}  // namespace scanknit
