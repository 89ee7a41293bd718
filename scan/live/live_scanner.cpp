#include "scan/live/live_scanner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>
#include <vector>

#include "acquire/live/loss_names.h"
#include "acquire/sensor/scanner_camera.h"

namespace scanknit {
namespace {

std::string stream_text(const StreamProfile& stream) {
  return fmt::format("{} {}x{} {} at {:.3g} frames a second",
                     stream.format == PixelFormat::kY8i  ? "infrared pairs"
                     : stream.kind == StreamKind::kDepth ? "depth"
                                                         : "colour",
                     stream.width, stream.height, to_string(stream.format), stream.frames_per_second);
}

void leave_out_colour(std::vector<StreamProfile>& streams) {
  std::erase_if(streams, [](const StreamProfile& stream) { return stream.kind == StreamKind::kColour; });
}

/// If the pose of the colour camera is unknown, colour does not fit depth: it is not used unless the user asks for it.
void choose_colour(LiveScanner& scanner, const AcquireConfig& config, ScanSession& session) {
  const bool has_colour = scanner.streams.size() > 1;
  const bool is_stated = config.camera && config.camera->colour && config.camera->T_colour_depth;
  if (!has_colour || scanner.calibration.colour_unknown.empty() || is_stated) return;
  const std::string why = "it is not known where the colour camera is: " + scanner.calibration.colour_unknown;
  if (config.colour == ScannerColour::kRegistered) {
    session.warn(WarningCode::kScanner,
                 why + ". Colour is used as if both cameras had the same viewpoint, as acquire.colour says");
    return;
  }
  session.warn(
      WarningCode::kScanner,
      why + ". Colour is left out; acquire.colour: registered uses it as if both cameras had the same viewpoint");
  leave_out_colour(scanner.streams);
}

/// Refuses intrinsics of another picture size before the scan: with them every picture would be useless.
Result<void> check_size(const LiveScanner& scanner) {
  const StreamProfile& depth = scanner.streams.front();
  const CameraIntrinsics& camera = scanner.calibration.depth.intrinsics;
  if (camera.width == 0 || (camera.width == depth.width && camera.height == depth.height)) return {};
  return Error{ErrorCode::kConfig,
               fmt::format("acquire.intrinsics is for pictures of {} x {}, but the camera sends {} x {}; ask the "
                           "camera for that size",
                           camera.width, camera.height, depth.width, depth.height),
               scanner.device->info().name};
}

Result<void> check_depth_camera(const LiveScanner& scanner, const AcquireConfig& config, Calibration need,
                                ScanSession& session) {
  const std::string& why = scanner.calibration.depth_unknown;
  if (why.empty() || (config.camera && config.camera->depth)) return {};
  if (need == Calibration::kRequired) {
    return Error{ErrorCode::kDevice, why + ". Give the depth camera's intrinsics as acquire.intrinsics",
                 scanner.device->info().name};
  }
  session.warn(WarningCode::kScanner,
               why + ". The pictures are recorded all the same; a scan of them needs acquire.intrinsics");
  return {};
}

/// Without the scanner's calibration pairs are of no use, later neither.
Result<void> check_pair(const LiveScanner& scanner, const AcquireConfig& config) {
  const std::string& name = scanner.device->info().name;
  if (auto allowed = refuse_other_cameras(config, name); !allowed) return allowed;
  const std::string& why = scanner.calibration.depth_unknown;
  if (why.empty()) return {};
  return Error{ErrorCode::kDevice,
               why + ". Without the cameras of its pairs there is no depth: take its own with acquire.geometry=depth",
               name};
}

void apply(const ScannerSettings& settings, DeviceSource& device, ScanSession& session) {
  const auto set = [&](const char* key, DeviceControl control, std::optional<int> value) {
    if (!value) return;
    if (const auto done = device.set_control(control, *value); !done) {
      session.warn(WarningCode::kScanner, fmt::format("{} has no effect: {}", key, done.error().text()));
    }
  };
  set("acquire.preset", DeviceControl::kPreset, settings.preset);  // first, because it changes the others
  set("acquire.emitter", DeviceControl::kEmitter, settings.emitter);
  set("acquire.laser_power", DeviceControl::kLaserPower, settings.laser_power_mw);
}

}  // namespace

Result<LiveScanner> open_scanner(const ScannerRequest& request, const ScanConfig& config, Calibration need,
                                 const std::stop_token& stop, ScanSession& session) {
  DeviceOptions options;
  options.intrinsics = config.acquire.intrinsics;
  options.depth_scale = config.acquire.depth_scale;
  options.holds_automatics = config.scanner.locks_exposure;
  options.wait_s = request.wait_s;
  options.reconnect_s = request.reconnect_s;
  options.takes_from_others = request.takes_from_others;
  auto device = open_camera(request.device, options, stop);
  if (!device) return device.error();

  LiveScanner scanner;
  scanner.device = *std::move(device);
  const bool wants_pairs = config.acquire.geometry == Geometry::kStereo;
  scanner.streams = choose_streams(scanner.device->profiles(), request.width, request.height, request.frames_per_second,
                                   wants_pairs ? PixelFormat::kY8i : PixelFormat::kZ16);
  const std::string& uri = scanner.device->info().uri;
  if (scanner.streams.empty()) {
    return Error{ErrorCode::kDevice,
                 wants_pairs ? "the camera offers no pairs of infrared pictures (Y8I), as RealSense D400 cameras do on "
                               "USB 3; take its depth with acquire.geometry=depth"
                             : "the camera offers no depth stream",
                 uri};
  }
  if (config.acquire.colour == ScannerColour::kOff) leave_out_colour(scanner.streams);
  auto calibration = scanner.device->calibration(scanner.streams);
  if (!calibration) return calibration.error();
  scanner.calibration = *std::move(calibration);
  session.info(fmt::format("{} ({}), calibration: {}", scanner.device->info().name, uri, scanner.calibration.source));
  for (const std::string& warning : scanner.calibration.warnings) session.warn(WarningCode::kScanner, warning);
  if (auto usable = wants_pairs ? check_pair(scanner, config.acquire)
                                : check_depth_camera(scanner, config.acquire, need, session);
      !usable) {
    return usable.error();
  }
  if (auto fits = check_size(scanner); !fits) return fits.error();
  choose_colour(scanner, config.acquire, session);
  apply(config.scanner, *scanner.device, session);
  for (const StreamProfile& stream : scanner.streams) session.info(stream_text(stream));
  return scanner;
}

LiveOptions live_options(const ScannerRequest& request, PoseMode poses, ScanSession& session) {
  LiveOptions options;
  options.poses = poses;
  options.frames = request.frames;
  options.seconds = request.seconds;
  options.survives_unplugging = request.reconnect_s > 0;
  options.on_event = [&session](const DeviceEvent& event) { session.warn(WarningCode::kScanner, event.text); };
  return options;
}

void warn_of_losses(const LossCounters& losses, ScanSession& session) {
  if (losses.total() == 0) return;
  std::vector<std::string> parts;
  for (const auto& [where, count] : losses_by_name(losses)) parts.push_back(fmt::format("{} {}", where, count));
  session.warn(WarningCode::kPicturesLost,
               fmt::format("pictures lost: {}; docs/devices.md says what the words mean", fmt::join(parts, ", ")));
}

}  // namespace scanknit
