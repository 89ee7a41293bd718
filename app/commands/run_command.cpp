#include <charconv>
#include <string>
#include <system_error>

#include "app/commands/mesh_command.h"
#include "scan/scan.h"

namespace scanknit {
namespace {

constexpr const char* kAllClasses = "all";

Result<void> choose_class(const std::string& text, AcquireConfig& acquire) {
  if (text == kAllClasses) return {};
  constexpr int kMost = 255;
  int number = -1;
  const char* const end = text.data() + text.size();
  const auto [last, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc() || last != end || number < 0 || number > kMost) {
    return Error{ErrorCode::kUsage, "--class: expected all, or the value of a class's pixels, 0 to 255", text};
  }
  acquire.mask_class = number;
  return {};
}

}  // namespace

MeshCommand mesh_command_of(const RunArguments& arguments, const ConfigSources& config) {
  MeshCommand command{.input = arguments.recording, .config = with_run_defaults(config), .outputs = arguments.outputs};
  command.view = arguments.view;
  command.configure = [&](ScanConfig& scan) {
    scan.acquire.from = arguments.from;
    scan.acquire.every = arguments.every;
    if (arguments.to) scan.acquire.to = *arguments.to;
    return arguments.mask_class ? choose_class(*arguments.mask_class, scan.acquire) : Result<void>();
  };
  command.complete = [&](ScanJob& job) {
    job.pace = arguments.pace;
    job.angles = arguments.angles;
    job.cut_recording = arguments.cut_recording;
    job.meshes_each_class = arguments.mask_class == kAllClasses;
  };
  command.scan = [](const ScanJob& job, const LoadedConfig&, ScanObserver& observer, const std::stop_token& stop) {
    return scan_recording(job, observer, stop);
  };
  return command;
}

}  // namespace scanknit
