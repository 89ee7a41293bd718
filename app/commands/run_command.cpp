#include <fmt/format.h>

#include <charconv>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "app/commands/mesh_command.h"
#include "app/config/rig_file.h"
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

/// The rig of --rig with its recordings, or why it cannot be scanned.
Result<Rig> rig_of(const RunArguments& arguments, const ScanConfig& config) {
  const auto refuse = [](std::string message) { return Error{ErrorCode::kUsage, std::move(message), {}}; };
  if (config.turntable.is_enabled) return refuse("--rig: a turntable is scanned by one camera; the rig must see all");
  if (config.acquire.geometry != Geometry::kDepth) return refuse("--rig: only depth pictures, acquire.geometry=depth");
  if (arguments.mask_class) return refuse("--rig and --class do not go together");
  auto rig = read_rig_file(*arguments.rig);
  if (!rig) return rig;
  const std::size_t recordings = 1 + arguments.beside.size();
  if (rig->cameras.size() != recordings) {
    return refuse(
        fmt::format("{} has {} cameras, and the command line {} recordings; expected one of each camera, in "
                    "the file's order",
                    arguments.rig->string(), rig->cameras.size(), recordings));
  }
  for (std::size_t i = 0; i < recordings; ++i) {
    rig->cameras[i].recording = i == 0 ? arguments.recording : arguments.beside[i - 1];
  }
  return rig;
}

}  // namespace

MeshCommand mesh_command_of(const RunArguments& arguments, const ConfigSources& config) {
  MeshCommand command{.input = arguments.recording, .config = with_run_defaults(config), .outputs = arguments.outputs};
  command.view = arguments.view;
  const auto rig = std::make_shared<Rig>();
  command.configure = [&arguments, rig](ScanConfig& scan) -> Result<void> {
    if (!arguments.rig && !arguments.beside.empty()) {
      return Error{ErrorCode::kUsage,
                   "several recordings: of cameras whose places are known, give --rig RIG.yaml; of "
                   "places to be found, use `scanknit align`"};
    }
    if (arguments.rig) {
      auto read = rig_of(arguments, scan);
      if (!read) return read.error();
      *rig = *std::move(read);
    }
    scan.acquire.from = arguments.from;
    scan.acquire.every = arguments.every;
    if (arguments.to) scan.acquire.to = *arguments.to;
    return arguments.mask_class ? choose_class(*arguments.mask_class, scan.acquire) : Result<void>();
  };
  command.complete = [&arguments, rig](ScanJob& job) {
    if (arguments.rig) job.rig = rig;
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
