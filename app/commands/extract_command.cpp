#include "app/commands/mesh_command.h"
#include "scan/mesh/write_texture.h"
#include "scan/volume/extract_volume.h"

namespace scanknit {
namespace {

IsovalueSetting isovalue_setting(const ExtractArguments& arguments, const ScanJob& job) {
  if (arguments.wants_auto_isovalue) return IsovalueSetting::kAuto;
  return job.gives("extract.isovalue") ? IsovalueSetting::kGiven : IsovalueSetting::kNotGiven;
}

}  // namespace

MeshCommand mesh_command_of(const ExtractArguments& arguments, const ConfigSources& config) {
  MeshCommand command{.input = arguments.volume, .config = config, .outputs = arguments.outputs};
  command.has_case_table = arguments.wants_stats;
  command.configure = [](const ScanConfig& scan) { return refuse_texture(scan, "extract"); };
  // A volume is meshed as a whole, or, at a second signal, not at all.
  command.scan = [&](const ScanJob& job, ScanObserver& observer, const std::stop_token& stop) {
    return extract_volume(job, {arguments.options, isovalue_setting(arguments, job)}, observer, stop);
  };
  return command;
}

}  // namespace scanknit
