#include "app/commands/mesh_command.h"
#include "scan/volume/extract_volume.h"

namespace scanknit {
namespace {

IsovalueSetting isovalue_setting(const ExtractArguments& arguments, const LoadedConfig& loaded) {
  if (arguments.wants_auto_isovalue) return IsovalueSetting::kAuto;
  return loaded.gives("extract.isovalue") ? IsovalueSetting::kGiven : IsovalueSetting::kNotGiven;
}

}  // namespace

MeshCommand mesh_command_of(const ExtractArguments& arguments, const ConfigSources& config) {
  MeshCommand command{.input = arguments.volume, .config = config, .outputs = arguments.outputs};
  command.has_case_table = arguments.wants_stats;
  command.configure = [](const ScanConfig& scan) { return refuse_texture(scan, "extract"); };
  // A volume is meshed as a whole, or, at a second signal, not at all.
  command.scan = [&](const ScanJob& job, const LoadedConfig& loaded, ScanObserver& observer,
                     const std::stop_token& stop) {
    return extract_volume(job, {arguments.options, isovalue_setting(arguments, loaded)}, observer, stop);
  };
  return command;
}

}  // namespace scanknit
