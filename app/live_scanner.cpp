#include "app/live_scanner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>
#include <vector>

namespace scanknit {
namespace {

std::string stream_text(const StreamProfile& stream) {
  return fmt::format("{} {}x{} {} at {:.3g} frames a second", stream.kind == StreamKind::kDepth ? "depth" : "colour",
                     stream.width, stream.height, to_string(stream.format), stream.frames_per_second);
}

}  // namespace

Result<LiveScanner> open_scanner(const ScannerArguments& arguments, const AcquireConfig& config, std::stop_token stop,
                                 Console& console) {
  DeviceOptions options;
  options.intrinsics = config.intrinsics;
  options.depth_scale = config.depth_scale;
  options.wait_s = arguments.wait_s;
  options.reconnect_s = arguments.reconnect_s;
  options.takes_from_others = arguments.takes_from_others;
  auto device = open_camera(arguments.device, options, stop);
  if (!device) return device.error();

  LiveScanner scanner;
  scanner.device = *std::move(device);
  scanner.streams =
      choose_streams(scanner.device->profiles(), arguments.width, arguments.height, arguments.frames_per_second);
  const std::string& uri = scanner.device->info().uri;
  if (scanner.streams.empty()) {
    return Error{ErrorCode::kDevice, "the camera offers no depth stream; `scanknit doctor` tells more", uri};
  }
  auto calibration = scanner.device->calibration(scanner.streams);
  if (!calibration) return calibration.error();
  scanner.calibration = *std::move(calibration);
  console.info(fmt::format("{} ({}), calibration: {}", scanner.device->info().name, uri, scanner.calibration.source));
  for (const StreamProfile& stream : scanner.streams) console.info(stream_text(stream));
  return scanner;
}

LiveOptions live_options(const ScannerArguments& arguments, PoseMode poses, Console& console) {
  LiveOptions options;
  options.poses = poses;
  options.frames = arguments.frames;
  options.seconds = arguments.seconds;
  options.survives_unplugging = arguments.reconnect_s > 0;
  options.on_event = [&console](const DeviceEvent& event) { console.warn(event.text); };
  return options;
}

std::map<std::string, std::uint64_t> named(const LossCounters& losses) {
  return {{"device", losses.device},
          {"transport", losses.transport},
          {"overflow", losses.overflow},
          {"queue", losses.queue},
          {"writer", losses.writer}};
}

void warn_of_losses(const LossCounters& losses, Console& console) {
  if (losses.total() == 0) return;
  std::vector<std::string> parts;
  for (const auto& [where, count] : named(losses)) parts.push_back(fmt::format("{} {}", where, count));
  console.warn(fmt::format("pictures lost: {}; docs/devices.md says what the words mean", fmt::join(parts, ", ")));
}

}  // namespace scanknit
