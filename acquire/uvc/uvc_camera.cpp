#include "acquire/uvc/uvc_camera.h"

#include <pthread.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "acquire/usb/link_speed.h"
#include "acquire/usb/quirks.h"
#include "acquire/uvc/realsense.h"
#include "acquire/uvc/uvc_selection.h"
#include "acquire/uvc/uvc_stream.h"

namespace scanknit {
namespace {

using std::chrono::milliseconds;

constexpr double kSilentFrames = 10;
constexpr int kMostRestarts = 5;  // in a row, without a frame between them
constexpr milliseconds kBeforeHolding{1000};
constexpr std::size_t kUsbMemory = 12u << 20;  // of the 16 MB that Linux gives to all programs together

// Controls of cameras and processing units (UVC 1.5, tables ).
constexpr std::uint8_t kSetCurrent = 0x01;
constexpr std::uint16_t kAutoExposureMode = 0x0200;
constexpr std::uint16_t kAutoWhiteBalance = 0x0B00;
constexpr std::byte kManualExposure{1};
constexpr std::byte kAperturePriority{8};

const StreamProfile* find_kind(std::span<const StreamProfile> streams, StreamKind kind) {
  const auto found =
      std::find_if(streams.begin(), streams.end(), [&](const StreamProfile& p) { return p.kind == kind; });
  return found == streams.end() ? nullptr : &*found;
}

std::string link_name(int speed_mbit) {
  return speed_mbit >= kSuperSpeedMbit ? "USB 3" : "USB 2";
}

class UvcCamera final : public DeviceSource {
 public:
  UvcCamera(std::unique_ptr<UsbHandle> handle, std::vector<UvcFunction> functions, const DeviceOptions& options,
            std::stop_token stop)
      : handle_(std::move(handle)),
        functions_(std::move(functions)),
        quirk_(quirk_of(handle_->info().vendor, handle_->info().product)),
        options_(options),
        info_(describe_camera(handle_->info())),
        stop_(std::move(stop)),
        on_stop_(stop_, [this] { handle_->hurry(true); }) {}
  ~UvcCamera() override { stop(); }

  [[nodiscard]] const DeviceInfo& info() const override { return info_; }
  [[nodiscard]] std::vector<StreamProfile> profiles() const override;
  [[nodiscard]] Result<RawCalibration> calibration(std::span<const StreamProfile> streams) override;
  [[nodiscard]] Result<void> start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) override;
  void stop() override;
  [[nodiscard]] LossCounters losses() const override;
  [[nodiscard]] Result<void> set_control(DeviceControl control, int value) override;

 private:
  /// What is known of a stream's recovery, by the watching thread.
  struct Watched {
    std::unique_ptr<UvcStream> stream;
    milliseconds silence{0};  // longer than this is too long
    std::uint64_t frames_at_restart = 0;
    int restarts = 0;
    bool is_recovering = false;
    bool is_given_up = false;
  };

  [[nodiscard]] std::optional<RealsenseUnit> realsense_unit();
  void read_own_calibration(std::span<const StreamProfile> streams, RawCalibration& calibration);
  void read_depth_unit(RealsenseUnit& unit, RawCalibration& calibration);
  void take_usual_unit(RawCalibration& calibration, const std::string& why) const;
  [[nodiscard]] Result<void> add_stream(const StreamProfile& profile, std::size_t budget_bytes);
  [[nodiscard]] Result<void> set_colour_automatics(bool is_automatic);
  void warn_of_slow_link(std::span<const StreamProfile> streams);
  void watch(const std::stop_token& stop);
  [[nodiscard]] bool look_at(Watched& watched, bool has_overslept);
  [[nodiscard]] bool restart(Watched& watched, DeviceEvent::Kind kind, const std::string& what);
  [[nodiscard]] bool give_up(Watched& watched, const std::string& what);
  void wake_up();
  void tell(DeviceEvent::Kind kind, const std::string& text) { events_({kind, info_.name + ": " + text}); }

  std::unique_ptr<UsbHandle> handle_;
  const std::vector<UvcFunction> functions_;
  const CameraQuirk quirk_;
  const DeviceOptions options_;
  const DeviceInfo info_;
  const std::stop_token stop_;
  const std::stop_callback<std::function<void()>> on_stop_;
  FrameSink frames_;
  EventSink events_;
  std::vector<Watched> streams_;  // empty: not started
  LossCounters losses_before_;    // of streams that were stopped
  std::chrono::steady_clock::time_point started_at_;
  bool is_holding_ = false;
  std::mutex mutex_;  // of is_trouble_ and clock_jumps_
  std::condition_variable_any changed_;
  bool is_trouble_ = false;
  int clock_jumps_ = 0;
  std::jthread watcher_;
};

std::vector<StreamProfile> UvcCamera::profiles() const {
  std::vector<StreamProfile> profiles;
  for (const UvcSelection& selection : selections_of(functions_, quirk_)) {
    if (std::find(profiles.begin(), profiles.end(), selection.profile) == profiles.end()) {
      profiles.push_back(selection.profile);
    }
  }
  return profiles;
}

std::optional<RealsenseUnit> UvcCamera::realsense_unit() {
  if (quirk_.calibration != CalibrationReader::kRealsense) return std::nullopt;
  for (const UvcFunction& function : functions_) {
    if (const std::uint8_t unit = realsense_unit_of(function); unit != 0) {
      return RealsenseUnit(*handle_, function, unit);
    }
  }
  return std::nullopt;
}

void UvcCamera::read_own_calibration(std::span<const StreamProfile> streams, RawCalibration& calibration) {
  const StreamProfile* depth = find_kind(streams, StreamKind::kDepth);
  auto unit = realsense_unit();
  if (!unit || depth == nullptr) {
    calibration.depth_unknown = calibration.colour_unknown = info_.name + " does not tell its calibration";
    return;
  }
  const auto camera = unit->depth_camera(depth->width, depth->height);
  if (!camera) {  // nothing else is asked: each request that is not answered takes a second
    calibration.depth_unknown = calibration.colour_unknown = camera.error().message;
    take_usual_unit(calibration, "it tells no calibration");
    return;
  }
  calibration.depth.intrinsics = *camera;
  calibration.source = "the camera's own";
  if (depth->format == PixelFormat::kY8i) {
    const auto baseline_m = unit->baseline_m();
    if (baseline_m) {
      calibration.baseline_m = *baseline_m;
    } else {
      calibration.depth_unknown = baseline_m.error().message;
    }
  } else {
    read_depth_unit(*unit, calibration);
  }
  const StreamProfile* colour = find_kind(streams, StreamKind::kColour);
  if (colour == nullptr) return;
  if (const auto read = unit->colour_camera(colour->width, colour->height)) {
    calibration.colour = read->camera;
    calibration.T_colour_depth = read->T_colour_depth;
  } else {
    calibration.colour_unknown = read.error().message;
  }
}

/// The kind's usual one stays where the camera does not tell.
void UvcCamera::read_depth_unit(RealsenseUnit& unit, RawCalibration& calibration) {
  if (options_.depth_scale) return;
  const auto unit_m = unit.depth_unit_m();
  if (unit_m) {
    calibration.depth_unit_m = *unit_m;
  } else {
    take_usual_unit(calibration, unit_m.error().message);
  }
}

void UvcCamera::take_usual_unit(RawCalibration& calibration, const std::string& why) const {
  if (options_.depth_scale) return;
  std::array<char, 32> unit{};
  std::snprintf(unit.data(), unit.size(), "%g mm", 1000 * quirk_.depth_unit_m);
  calibration.warnings.push_back("the camera does not tell its depth unit (" + why + "): " + unit.data() +
                                 " is taken, as its kind has it unless it was changed. Else state acquire.depth_scale");
}

Result<RawCalibration> UvcCamera::calibration(std::span<const StreamProfile> streams) {
  RawCalibration calibration;
  calibration.device = info_.name;
  calibration.serial = info_.serial;
  calibration.depth_unit_m = options_.depth_scale ? 1 / *options_.depth_scale : quirk_.depth_unit_m;
  calibration.source = "unknown";
  read_own_calibration(streams, calibration);
  if (!options_.intrinsics) return calibration;
  calibration.depth = *options_.intrinsics;
  const StreamProfile* depth = find_kind(streams, StreamKind::kDepth);
  if (depth != nullptr && calibration.depth.intrinsics.width == 0) {
    calibration.depth.intrinsics.width = depth->width;
    calibration.depth.intrinsics.height = depth->height;
  }
  const std::string why = std::exchange(calibration.depth_unknown, "");
  calibration.source = why.empty() ? "acquire.intrinsics" : "acquire.intrinsics (" + why + ")";
  return calibration;
}

Result<void> UvcCamera::add_stream(const StreamProfile& profile, std::size_t budget_bytes) {
  const auto all = selections_of(functions_, quirk_);
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const UvcSelection& selection) { return selection.profile == profile; });
  if (found == all.end()) {
    return Error{ErrorCode::kDevice,
                 std::string("the camera does not offer ") + to_string(profile.format) + " " +
                     std::to_string(profile.width) + "x" + std::to_string(profile.height) + " at this rate",
                 info_.name};
  }
  const std::uint32_t ticks = quirk_.ticks_per_second > 0 ? quirk_.ticks_per_second : found->function->clock_hz;
  UvcStream::Sinks sinks{frames_, [this] { wake_up(); },
                         [this] {
                           const std::lock_guard lock(mutex_);
                           ++clock_jumps_;
                         }};
  const double silence_s = std::max(options_.silence_s, kSilentFrames * 1e-7 * found->interval_100ns);
  Watched watched;
  watched.stream = std::make_unique<UvcStream>(*handle_, *found, ticks, budget_bytes, std::move(sinks));
  watched.silence = milliseconds(static_cast<int>(std::ceil(1000 * silence_s)));
  streams_.push_back(std::move(watched));
  return {};
}

Result<void> UvcCamera::start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) {
  if (!streams_.empty()) return Error{ErrorCode::kDevice, "the camera streams already", info_.name};
  handle_->hurry(stop_.stop_requested());
  frames_ = std::move(frames);
  events_ = std::move(events);
  losses_before_ = {};
  is_trouble_ = is_holding_ = false;
  clock_jumps_ = 0;
  Result<void> done;
  for (const StreamProfile& profile : streams) {
    if (done) done = add_stream(profile, kUsbMemory / streams.size());
  }
  // A scan that was killed has left them held.
  if (done && options_.holds_automatics) (void)set_colour_automatics(true);
  for (Watched& watched : streams_) {
    if (done) done = watched.stream->start();
  }
  if (!done) {
    streams_.clear();
    return done.error();
  }
  warn_of_slow_link(streams);
  started_at_ = std::chrono::steady_clock::now();
  watcher_ = std::jthread([this](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "usb-watch");
    watch(stop);
  });
  return {};
}

void UvcCamera::stop() {
  handle_->hurry(true);
  if (watcher_.joinable()) {
    watcher_.request_stop();
    watcher_.join();
  }
  // Answers end on the thread `usb`, which a slow sink may have kept busy until now.
  for (Watched& watched : streams_) watched.stream->take_back();
  handle_->hurry(true);
  for (Watched& watched : streams_) watched.stream->stop();
  if (std::exchange(is_holding_, false)) (void)set_colour_automatics(true);
  losses_before_ = losses();
  streams_.clear();
}

LossCounters UvcCamera::losses() const {
  LossCounters sum = losses_before_;
  for (const Watched& watched : streams_) sum += watched.stream->losses();
  return sum;
}

void UvcCamera::warn_of_slow_link(std::span<const StreamProfile> streams) {
  const double asked = bandwidth_of(streams);
  if (info_.speed_mbit >= kSuperSpeedMbit || info_.speed_mbit == 0 || asked < kHighSpeedBytesPerSecond) return;
  std::array<char, 160> text{};
  std::snprintf(
      text.data(), text.size(),
      "%.1f MB/s are asked for on a USB 2 link, which carries about %.0f. Use a USB 3 port and cable, and plug "
      "it in quickly",
      asked / 1e6, kHighSpeedBytesPerSecond / 1e6);
  tell(DeviceEvent::Kind::kSlowLink, text.data());
}

void UvcCamera::wake_up() {
  {
    const std::lock_guard lock(mutex_);
    is_trouble_ = true;
  }
  changed_.notify_all();
}

void UvcCamera::watch(const std::stop_token& stop) {
  const auto shortest = std::min_element(streams_.begin(), streams_.end(), [](const Watched& a, const Watched& b) {
                          return a.silence < b.silence;
                        })->silence;
  while (!stop.stop_requested()) {
    int jumps = 0;
    const auto before = std::chrono::steady_clock::now();
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, stop, shortest / 4, [this] { return is_trouble_; });
      is_trouble_ = false;
      jumps = std::exchange(clock_jumps_, 0);
    }
    if (stop.stop_requested()) return;
    if (jumps > 0) tell(DeviceEvent::Kind::kClockJump, "its clock jumped; this computer's is used instead");
    // A computer so busy that we slept too long has kept frames from us, too: they may be waiting.
    const bool has_overslept = std::chrono::steady_clock::now() - before > shortest / 2;
    for (Watched& watched : streams_) {
      if (!look_at(watched, has_overslept)) return;
    }
    const bool is_time = std::chrono::steady_clock::now() - started_at_ > kBeforeHolding;
    if (options_.holds_automatics && is_time && !is_holding_) {
      is_holding_ = true;
      (void)set_colour_automatics(false);  // a camera without these controls has nothing to hold
    }
  }
}

/// False: there is nothing to watch any more.
bool UvcCamera::look_at(Watched& watched, bool has_overslept) {
  if (watched.is_given_up) return true;
  UvcStream& stream = *watched.stream;
  if (watched.is_recovering && stream.frames() > watched.frames_at_restart) {
    watched.is_recovering = false;
    watched.restarts = 0;
    tell(DeviceEvent::Kind::kRecovered, "frames come again");
  }
  const bool is_alone = streams_.size() == 1;
  const std::string name = is_alone ? "data" : stream.profile().kind == StreamKind::kDepth ? "depth" : "colour";
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const std::chrono::nanoseconds quiet = now - std::chrono::nanoseconds(stream.last_picture_ns());
  switch (stream.state()) {
    case TransferRing::State::kGone:
      for (Watched& each : streams_) each.stream->stop();
      tell(DeviceEvent::Kind::kLeft, "unplugged");
      return false;
    case TransferRing::State::kHalted:
      return restart(watched, DeviceEvent::Kind::kStalled, (is_alone ? "it" : name) + " stopped with an error");
    default: break;
  }
  if (has_overslept || quiet <= watched.silence) return true;
  const std::string since = " for " + std::to_string(quiet / milliseconds(1)) + " ms";
  const std::string link = " on a " + link_name(info_.speed_mbit) + " link";
  const LossCounters lost = stream.losses_since_picture();
  if (lost.total() == 0) {
    return restart(watched, DeviceEvent::Kind::kSilent,
                   "no " + name + since + link + ". Check the cable and the hub's power");
  }
  return restart(watched, DeviceEvent::Kind::kDamaged,
                 "no good " + (is_alone ? "" : name + " ") + "picture" + since + link +
                     ", all are damaged: " + std::to_string(lost.transport) + " incomplete or marked as bad, " +
                     std::to_string(lost.overflow) + " too long. Check the cable, the hub and its power");
}

bool UvcCamera::restart(Watched& watched, DeviceEvent::Kind kind, const std::string& what) {
  if (watched.restarts >= kMostRestarts) return give_up(watched, what);
  if (!watched.is_recovering) tell(kind, what);
  ++watched.restarts;
  watched.is_recovering = true;
  watched.frames_at_restart = watched.stream->frames();
  const auto restarted = watched.stream->restart();
  if (restarted || watched.stream->state() == TransferRing::State::kGone) return true;
  if (!is_unplugged(restarted.error())) {
    wake_up();  // and count one more
    return true;
  }
  for (Watched& each : streams_) each.stream->stop();
  tell(DeviceEvent::Kind::kLeft, "unplugged");
  return false;
}

/// Without depth there is nothing to scan; without colour there is.
bool UvcCamera::give_up(Watched& watched, const std::string& what) {
  const std::string why =
      what + "; it was started " + std::to_string(kMostRestarts) + " times again without a good picture. ";
  if (streams_.size() > 1 && watched.stream->profile().kind == StreamKind::kColour) {
    watched.stream->stop();
    watched.is_given_up = true;
    tell(DeviceEvent::Kind::kNoColour, why + kGoesOnWithoutColour);
    return true;
  }
  for (Watched& each : streams_) each.stream->stop();
  tell(DeviceEvent::Kind::kFailed, why + "Re-plug it");
  return false;
}

Result<void> UvcCamera::set_colour_automatics(bool is_automatic) {
  Result<void> done = Error{ErrorCode::kDevice, "the camera has no colour exposure or white balance", info_.name};
  const auto all = selections_of(functions_, quirk_);
  for (const UvcFunction& function : functions_) {
    const bool offers_colour = std::ranges::any_of(all, [&](const UvcSelection& selection) {
      return selection.function == &function && selection.profile.kind == StreamKind::kColour;
    });
    if (!offers_colour) continue;
    const auto index = [&](std::uint8_t unit) {
      return static_cast<std::uint16_t>(unit << 8 | function.control_interface);
    };
    if (function.camera_terminal != 0) {
      const std::array mode = {is_automatic ? kAperturePriority : kManualExposure};
      done = handle_->write_class(kSetCurrent, kAutoExposureMode, index(function.camera_terminal), mode);
    }
    if (function.processing_unit != 0) {
      const std::array on = {std::byte{is_automatic}};
      const auto balance = handle_->write_class(kSetCurrent, kAutoWhiteBalance, index(function.processing_unit), on);
      if (done || function.camera_terminal == 0) done = balance;
    }
  }
  return done;
}

Result<void> UvcCamera::set_control(DeviceControl control, int value) {
  if (control == DeviceControl::kColourAutomatics) return set_colour_automatics(value != 0);
  auto unit = realsense_unit();
  if (!unit) return Error{ErrorCode::kDevice, "the camera has no such control", info_.name};
  switch (control) {
    case DeviceControl::kEmitter: return unit->set(RealsenseControl::kEmitter, value);
    case DeviceControl::kLaserPower: return unit->set(RealsenseControl::kLaserPower, value);
    case DeviceControl::kPreset: return unit->set(RealsenseControl::kPreset, value);
    default: return unit->set(RealsenseControl::kAutoExposure, value);
  }
}

}  // namespace

std::vector<UvcFunction> depth_functions_of(const UsbDeviceInfo& device) {
  auto functions = parse_uvc_configuration(device.configuration);
  if (!functions) return {};
  for (const UvcSelection& selection : selections_of(*functions, {})) {
    if (selection.profile.kind == StreamKind::kDepth) return std::move(*functions);
  }
  return {};
}

DeviceInfo describe_camera(const UsbDeviceInfo& device) {
  const CameraQuirk quirk = quirk_of(device.vendor, device.product);
  std::array<char, 16> numbers{};
  std::snprintf(numbers.data(), numbers.size(), "%04x:%04x", device.vendor, device.product);
  DeviceInfo info;
  info.uri = std::string("usb:") + numbers.data() + (device.serial.empty() ? "" : "/" + device.serial);
  info.name = quirk.vendor != 0             ? std::string(quirk.name)
              : device.product_name.empty() ? std::string("depth camera ") + numbers.data()
                                            : device.product_name;
  info.serial = device.serial;
  info.bus = device.bus;
  info.address = device.address;
  info.speed_mbit = device.speed_mbit;
  info.support = quirk.support;
  return info;
}

Result<std::unique_ptr<DeviceSource>> open_uvc_camera(UsbContext& context, const UsbDeviceInfo& device,
                                                      const DeviceOptions& options, std::stop_token stop) {
  auto functions = depth_functions_of(device);
  if (functions.empty()) {
    return Error{ErrorCode::kDevice, device.place() + " offers no depth pictures"};
  }
  if (!options.takes_from_others) {
    if (const auto free = refuse_if_used(device); !free) return free.error();
  }
  auto handle = context.open(device);
  if (!handle) return handle.error();
  for (const UvcFunction& function : functions) {
    if (const auto claimed = (*handle)->claim(function.control_interface); !claimed) return claimed.error();
  }
  return std::unique_ptr<DeviceSource>(
      std::make_unique<UvcCamera>(std::move(*handle), std::move(functions), options, std::move(stop)));
}

}  // namespace scanknit
