#include "acquire/openni2/openni2_camera.h"

#include <OniCAPI.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <future>
#include <mutex>
#include <new>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "acquire/field_of_view.h"
#include "acquire/openni2/library_threads.h"
#include "acquire/openni2/openni2_modes.h"
#include "acquire/openni2/openni2_plugin.h"
#include "acquire/silence_watch.h"
#include "acquire/steady_now.h"
#include "acquire/usb/clock_map.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kTicksPerSecond = 1'000'000;  // OpenNI's stamps are microseconds
constexpr auto kBeforeHolding = std::chrono::milliseconds(1000);
constexpr int kPatience_ms = 100;

Error failed(const std::string& what, const std::string& where) {
  std::string why = oniGetExtendedError();
  const auto last = why.find_last_not_of(" \t\r\n");
  why.erase(last == std::string::npos ? 0 : last + 1);
  return {ErrorCode::kDevice, what + (why.empty() ? "" : ": " + why), where};
}

/// The library, started. It counts by itself how often.
class OpenNi {
 public:
  OpenNi() : is_started_(oniInitialize(ONI_API_VERSION) == ONI_STATUS_OK) {}
  ~OpenNi() {
    if (is_started_) oniShutdown();
  }
  OpenNi(const OpenNi&) = delete;
  OpenNi& operator=(const OpenNi&) = delete;
  [[nodiscard]] bool is_started() const { return is_started_; }

 private:
  bool is_started_;
};

DeviceInfo describe(const OniDeviceInfo& device) {
  DeviceInfo info;
  info.uri = std::string(kOpenNi2Prefix) + device.uri;
  const std::string vendor = device.vendor, name = device.name;
  info.name = vendor.empty() || name.starts_with(vendor) ? name : vendor + " " + name;
  info.support = "should work";
  return info;
}

struct OniStreamState {
  OniStreamHandle handle = nullptr;
  std::vector<OniMode> modes;
  std::optional<OniMode> chosen = std::nullopt;  ///< since start()
  bool is_mirrored = false;                      ///< the driver mirrors, and cannot be told otherwise
  std::optional<DeviceClock> clock = std::nullopt;
  std::optional<int> last_index = std::nullopt;
  std::uint64_t sequence = 0;
  std::int64_t last_good_ns = 0;
  SilenceWatch watch{0};     ///< since the stream was started
  bool is_given_up = false;  ///< ... and not wanted any more

  [[nodiscard]] bool is_wanted() const { return chosen && !is_given_up; }
};

template <typename T>
std::optional<T> property_of(OniStreamHandle stream, int id) {
  T value{};
  int size = sizeof(value);
  if (oniStreamGetProperty(stream, id, &value, &size) != ONI_STATUS_OK || size != sizeof(value)) return std::nullopt;
  return value;
}

/// The picture's rows, one after another, the left side on the left. Nothing: the library's frame contradicts itself.
std::optional<std::vector<std::byte>> pixels_of(const OniFrame& frame, const OniMode& mode, bool is_mirrored) {
  const auto bytes = static_cast<const std::byte*>(frame.data);
  if (frame.dataSize <= 0) return std::nullopt;
  if (mode.profile.format == PixelFormat::kMjpeg) return std::vector<std::byte>(bytes, bytes + frame.dataSize);
  const std::size_t pixel_bytes = mode.profile.format == PixelFormat::kRgb8 ? 3 : 2;
  const auto row_bytes = static_cast<std::size_t>(mode.profile.width) * pixel_bytes;
  const auto rows = static_cast<std::size_t>(mode.profile.height), stride = static_cast<std::size_t>(frame.stride);
  const bool is_whole = frame.width == mode.profile.width && frame.height == mode.profile.height;
  if (!is_whole || frame.stride <= 0 || stride < row_bytes) return std::nullopt;
  if ((rows - 1) * stride + row_bytes > static_cast<std::size_t>(frame.dataSize)) return std::nullopt;
  std::vector<std::byte> pixels(rows * row_bytes);
  for (std::size_t y = 0; y < rows; ++y) std::memcpy(pixels.data() + y * row_bytes, bytes + y * stride, row_bytes);
  if (is_mirrored) mirror(pixels, static_cast<std::size_t>(mode.profile.width), pixel_bytes);
  return pixels;
}

class OpenNi2Camera final : public DeviceSource {
 public:
  OpenNi2Camera(DeviceInfo info, DeviceOptions options) : info_(std::move(info)), options_(std::move(options)) {}
  ~OpenNi2Camera() override;

  /// Once, before anything else.
  [[nodiscard]] Result<void> open();

  [[nodiscard]] const DeviceInfo& info() const override { return info_; }
  [[nodiscard]] std::vector<StreamProfile> profiles() const override;
  [[nodiscard]] Result<RawCalibration> calibration(std::span<const StreamProfile> streams) override;
  [[nodiscard]] Result<void> start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) override;
  void stop() override;
  [[nodiscard]] LossCounters losses() const override {
    const std::lock_guard lock(mutex_);
    return losses_;
  }
  [[nodiscard]] Result<void> set_control(DeviceControl control, int value) override;

 private:
  [[nodiscard]] Result<void> prepare(OniStreamState& stream, const StreamProfile& wanted);
  void register_depth_to_colour();
  [[nodiscard]] CameraModel model_of(const OniStreamState& stream, const StreamProfile& profile) const;
  [[nodiscard]] bool start_streams();
  void stop_streams();
  void run_within_memory(const std::stop_token& stop);
  void run(const std::stop_token& stop);
  [[nodiscard]] bool look_at(OniStreamState& stream);
  [[nodiscard]] bool give_up(OniStreamState& stream, const std::string& complaint);
  void restart(OniStreamState& stream);
  void take_frame(OniStreamState& stream);
  void hold_automatics(bool is_held);
  void tell(DeviceEvent::Kind kind, const std::string& text) { events_({kind, info_.name + ": " + text}); }
  [[nodiscard]] std::string oni_uri() const { return info_.uri.substr(std::string_view(kOpenNi2Prefix).size()); }
  [[nodiscard]] bool is_me(const OniDeviceInfo* device) const { return oni_uri() == device->uri; }

  const OpenNi library_;
  DeviceInfo info_;
  const DeviceOptions options_;
  OniDeviceHandle device_ = nullptr;
  OniCallbackHandle callbacks_ = nullptr;
  OniStreamState depth_, colour_;
  bool is_registered_ = false;
  bool is_file_ = false;  // played: it may pause as long as it likes
  FrameSink frames_;
  EventSink events_;
  std::atomic<bool> has_left_ = false, has_ended_ = false;  // told by threads of the library
  bool is_holding_ = false;
  mutable std::mutex mutex_;  // of losses_
  LossCounters losses_;
  std::stop_source stop_;
  std::future<void> running_;  // valid while it streams
};

OpenNi2Camera::~OpenNi2Camera() {
  stop();
  if (callbacks_ != nullptr) oniUnregisterDeviceCallbacks(callbacks_);
  for (const OniStreamState* stream : {&depth_, &colour_}) {
    if (stream->handle != nullptr) oniStreamDestroy(stream->handle);
  }
  if (device_ != nullptr) oniDeviceClose(device_);
}

Result<void> OpenNi2Camera::open() {
  if (!library_.is_started()) return failed("OpenNI2 does not start", info_.uri);
  OniDeviceCallbacks callbacks{};
  callbacks.deviceConnected = [](const OniDeviceInfo*, void*) {};
  callbacks.deviceDisconnected = [](const OniDeviceInfo* device, void* self) {
    auto& camera = *static_cast<OpenNi2Camera*>(self);
    if (camera.is_me(device)) camera.has_left_ = true;
  };
  callbacks.deviceStateChanged = [](const OniDeviceInfo* device, OniDeviceState state, void* self) {
    auto& camera = *static_cast<OpenNi2Camera*>(self);
    if (camera.is_me(device) && state == ONI_DEVICE_STATE_EOF) camera.has_ended_ = true;
  };
  if (oniRegisterDeviceCallbacks(&callbacks, this, &callbacks_) != ONI_STATUS_OK) callbacks_ = nullptr;
  if (oniDeviceOpen(oni_uri().c_str(), &device_) != ONI_STATUS_OK) {
    device_ = nullptr;
    return failed("OpenNI2 cannot open it", info_.uri);
  }
  OniDeviceInfo device{};
  if (oniDeviceGetInfo(device_, &device) == ONI_STATUS_OK) info_ = describe(device);
  depth_.modes = modes_of(device_, StreamKind::kDepth);
  colour_.modes = modes_of(device_, StreamKind::kColour);
  if (depth_.modes.empty()) return failed("it has no depth that can be read", info_.uri);
  if (oniDeviceCreateStream(device_, ONI_SENSOR_DEPTH, &depth_.handle) != ONI_STATUS_OK) {
    depth_.handle = nullptr;
    return failed("OpenNI2 cannot open its depth", info_.uri);
  }
  if (!colour_.modes.empty() && oniDeviceCreateStream(device_, ONI_SENSOR_COLOR, &colour_.handle) != ONI_STATUS_OK) {
    colour_.handle = nullptr;
    colour_.modes.clear();
  }
  is_registered_ = colour_.handle != nullptr &&
                   oniDeviceIsImageRegistrationModeSupported(device_, ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR) != FALSE;
  is_file_ = oniDeviceIsPropertySupported(device_, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED) != FALSE;
  const OniBool repeats = FALSE;  // a file ends where it ends
  oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED, &repeats, sizeof(repeats));
  return {};
}

std::vector<StreamProfile> OpenNi2Camera::profiles() const {
  std::vector<StreamProfile> profiles;
  for (const OniStreamState* stream : {&depth_, &colour_}) {
    for (const OniMode& mode : stream->modes) profiles.push_back(mode.profile);
  }
  return profiles;
}

/// Without intrinsics where the driver does not state a field of view.
CameraModel OpenNi2Camera::model_of(const OniStreamState& stream, const StreamProfile& profile) const {
  const auto x = property_of<float>(stream.handle, ONI_STREAM_PROPERTY_HORIZONTAL_FOV);
  const auto y = property_of<float>(stream.handle, ONI_STREAM_PROPERTY_VERTICAL_FOV);
  const auto known = intrinsics_of_view(profile.width, profile.height, double{x.value_or(0)}, double{y.value_or(0)});
  return {.intrinsics = known.value_or(CameraIntrinsics{})};
}

Result<RawCalibration> OpenNi2Camera::calibration(std::span<const StreamProfile> streams) {
  RawCalibration calibration;
  calibration.device = info_.name;
  calibration.source = "the field of view that OpenNI2 states";
  for (const StreamProfile& profile : streams) {
    const OniStreamState& stream = profile.kind == StreamKind::kDepth ? depth_ : colour_;
    const auto mode =
        std::find_if(stream.modes.begin(), stream.modes.end(), [&](const OniMode& m) { return m.profile == profile; });
    if (stream.handle == nullptr || mode == stream.modes.end()) continue;
    if (profile.kind == StreamKind::kColour) {
      calibration.colour = model_of(stream, profile);
    } else {
      // Depth that is moved into the colour camera has its view.
      calibration.depth = model_of(is_registered_ ? colour_ : depth_, profile);
      calibration.depth_unit_m = mode->pixel_format == ONI_PIXEL_FORMAT_DEPTH_100_UM ? 0.0001 : 0.001;
    }
  }
  if (options_.depth_scale) calibration.depth_unit_m = 1 / *options_.depth_scale;
  if (options_.intrinsics) {
    calibration.depth = *options_.intrinsics;
    calibration.colour = {};  // registered to depth
    calibration.source = "acquire.intrinsics";
  }
  if (calibration.depth.intrinsics.fx == 0) calibration.depth_unknown = "OpenNI2 does not tell its field of view";
  if (!is_registered_) calibration.colour_unknown = "its driver does not move depth into the colour camera";
  return calibration;
}

Result<void> OpenNi2Camera::prepare(OniStreamState& stream, const StreamProfile& wanted) {
  const auto mode =
      std::find_if(stream.modes.begin(), stream.modes.end(), [&](const OniMode& m) { return m.profile == wanted; });
  if (stream.handle == nullptr || mode == stream.modes.end()) {
    return Error{ErrorCode::kDevice, "the camera does not offer this stream", info_.uri};
  }
  const OniVideoMode asked{static_cast<OniPixelFormat>(mode->pixel_format), wanted.width, wanted.height,
                           static_cast<int>(wanted.frames_per_second)};
  const auto is_same = [&](const OniVideoMode& now) {
    return now.pixelFormat == asked.pixelFormat && now.resolutionX == asked.resolutionX &&
           now.resolutionY == asked.resolutionY && now.fps == asked.fps;
  };
  const auto now = property_of<OniVideoMode>(stream.handle, ONI_STREAM_PROPERTY_VIDEO_MODE);
  if ((!now || !is_same(*now)) &&
      oniStreamSetProperty(stream.handle, ONI_STREAM_PROPERTY_VIDEO_MODE, &asked, sizeof(asked)) != ONI_STATUS_OK) {
    return failed("the camera refuses this stream", info_.uri);
  }
  const OniBool is_mirrored = FALSE;
  oniStreamSetProperty(stream.handle, ONI_STREAM_PROPERTY_MIRRORING, &is_mirrored, sizeof(is_mirrored));
  stream.is_mirrored = property_of<OniBool>(stream.handle, ONI_STREAM_PROPERTY_MIRRORING).value_or(FALSE) != FALSE;
  const bool can_turn = wanted.format == PixelFormat::kZ16 || wanted.format == PixelFormat::kRgb8;
  if (stream.is_mirrored && !can_turn) {
    return Error{ErrorCode::kDevice, "the camera sends mirrored pictures of a kind that cannot be turned", info_.uri};
  }
  stream.chosen = *mode;
  stream.clock.emplace(kTicksPerSecond);
  stream.last_index.reset();
  stream.sequence = 0;
  stream.last_good_ns = 0;
  stream.is_given_up = false;
  return {};
}

void OpenNi2Camera::register_depth_to_colour() {
  if (!is_registered_) return;
  const OniImageRegistrationMode mode = ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &mode, sizeof(mode));
}

Result<void> OpenNi2Camera::start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) {
  if (running_.valid()) return Error{ErrorCode::kDevice, "the camera streams already", info_.uri};
  frames_ = std::move(frames);
  events_ = std::move(events);
  {
    const std::lock_guard lock(mutex_);
    losses_ = {};
  }
  depth_.chosen.reset();
  colour_.chosen.reset();
  for (const StreamProfile& wanted : streams) {
    if (auto ready = prepare(wanted.kind == StreamKind::kDepth ? depth_ : colour_, wanted); !ready) return ready;
  }
  register_depth_to_colour();
  if (!start_streams()) {
    const Error why = failed("the camera does not start", info_.uri);
    stop_streams();
    return why;
  }
  stop_ = {};
  try {
    running_ = begin_on_library_thread([this] { run_within_memory(stop_.get_token()); });
  } catch (const std::system_error& fault) {  // no thread is left
    stop_streams();
    return Error{ErrorCode::kBudget, std::string("no thread is left: ") + fault.what(), info_.uri};
  }
  return {};
}

void OpenNi2Camera::stop() {
  if (!running_.valid()) return;
  stop_.request_stop();
  running_.get();
  if (std::exchange(is_holding_, false)) hold_automatics(false);
  stop_streams();
}

bool OpenNi2Camera::start_streams() {
  for (const OniStreamState* stream : {&depth_, &colour_}) {
    if (stream->is_wanted() && oniStreamStart(stream->handle) != ONI_STATUS_OK) return false;
  }
  return true;
}

void OpenNi2Camera::stop_streams() {
  for (const OniStreamState* stream : {&depth_, &colour_}) {
    if (stream->chosen) oniStreamStop(stream->handle);
  }
}

void OpenNi2Camera::run_within_memory(const std::stop_token& stop) {
  try {
    run(stop);
  } catch (const std::bad_alloc&) {
    tell(DeviceEvent::Kind::kFailed, "out of memory");
  }
}

void OpenNi2Camera::run(const std::stop_token& stop) {
  const auto started = std::chrono::steady_clock::now();
  depth_.watch = colour_.watch = SilenceWatch(steady_now_ns());
  while (!stop.stop_requested()) {
    if (has_left_) return tell(DeviceEvent::Kind::kLeft, "unplugged");
    std::array<OniStreamHandle, 2> handles{};
    std::array<OniStreamState*, 2> states{};
    std::size_t count = 0;
    for (OniStreamState* stream : {&depth_, &colour_}) {
      if (!stream->is_wanted()) continue;
      states[count] = stream;
      handles[count++] = stream->handle;
    }
    int which = -1;
    const OniStatus status = oniWaitForAnyStream(handles.data(), static_cast<int>(count), &which, kPatience_ms);
    if (status == ONI_STATUS_OK && which >= 0 && static_cast<std::size_t>(which) < count) {
      take_frame(*states[static_cast<std::size_t>(which)]);
    } else if (has_ended_) {
      return tell(DeviceEvent::Kind::kFailed, "the recording has ended");
    } else if (status != ONI_STATUS_TIME_OUT) {
      std::this_thread::sleep_for(std::chrono::milliseconds(kPatience_ms));  // the silence below tells
    }
    const auto now = std::chrono::steady_clock::now();
    if (!is_file_ && !(look_at(depth_) && look_at(colour_))) return;
    if (options_.holds_automatics && !is_holding_ && now - started > kBeforeHolding) {
      is_holding_ = true;
      hold_automatics(true);
    }
  }
}

/// False: the camera was given up.
bool OpenNi2Camera::look_at(OniStreamState& stream) {
  if (!stream.is_wanted()) return true;
  const auto verdict = stream.watch.look(stream.last_good_ns, steady_now_ns());
  if (verdict == SilenceWatch::Verdict::kNothing) return true;
  if (verdict == SilenceWatch::Verdict::kRecovered)
    return tell(DeviceEvent::Kind::kRecovered, "frames come again"), true;
  const std::string name = stream.chosen->profile.kind == StreamKind::kDepth ? "depth" : "colour";
  const std::string complaint = "no good " + name + " for " +
                                std::to_string(SilenceWatch::kSilence / std::chrono::seconds(1)) +
                                " s. Check its cable, and try a port of its own";
  if (verdict == SilenceWatch::Verdict::kGiveUp) return give_up(stream, complaint);
  if (stream.watch.restarts() == 1) tell(DeviceEvent::Kind::kSilent, complaint);
  restart(stream);
  return true;
}

/// Without depth there is nothing to scan; without colour there is.
bool OpenNi2Camera::give_up(OniStreamState& stream, const std::string& complaint) {
  const std::string why =
      complaint + "; it was started " + std::to_string(stream.watch.restarts()) + " times again in vain. ";
  if (&stream == &colour_ && depth_.chosen) {
    oniStreamStop(colour_.handle);
    colour_.is_given_up = true;
    tell(DeviceEvent::Kind::kNoColour, why + kGoesOnWithoutColour);
    return true;
  }
  tell(DeviceEvent::Kind::kFailed, why + "Re-plug it");
  return false;
}

/// Colour alone where depth is well. What does not start stays silent.
void OpenNi2Camera::restart(OniStreamState& stream) {
  if (&stream == &colour_) {
    oniStreamStop(colour_.handle);
    (void)oniStreamStart(colour_.handle);
  } else {
    stop_streams();
    (void)start_streams();
    depth_.last_index.reset();  // counted anew
    depth_.watch.restarted(steady_now_ns());
  }
  colour_.last_index.reset();
  colour_.watch.restarted(steady_now_ns());
}

void OpenNi2Camera::take_frame(OniStreamState& stream) {
  OniFrame* frame = nullptr;
  if (oniStreamReadFrame(stream.handle, &frame) != ONI_STATUS_OK || frame == nullptr) return;
  const std::int64_t host_ns = steady_now_ns();
  // The library keeps the newest frame only: those between are gaps in its numbers.
  const int gap =
      stream.last_index && frame->frameIndex > *stream.last_index ? frame->frameIndex - *stream.last_index : 1;
  stream.last_index = frame->frameIndex;
  stream.sequence += static_cast<std::uint64_t>(gap);
  auto pixels = pixels_of(*frame, *stream.chosen, stream.is_mirrored);
  {
    const std::lock_guard lock(mutex_);
    losses_.device += static_cast<std::uint64_t>(gap - 1);
    if (!pixels) ++losses_.transport;
  }
  const DeviceClock::Stamp stamp = stream.clock->stamp(static_cast<std::uint32_t>(frame->timestamp), host_ns);
  oniFrameRelease(frame);
  if (!pixels) return;
  stream.last_good_ns = host_ns;
  frames_({stream.chosen->profile, stream.sequence - 1, stamp.device_ns, host_ns,
           std::make_shared<const std::vector<std::byte>>(*std::move(pixels))});
}

void OpenNi2Camera::hold_automatics(bool is_held) {
  if (!colour_.chosen) return;
  const OniBool is_automatic = is_held ? FALSE : TRUE;
  for (const int id : {ONI_STREAM_PROPERTY_AUTO_EXPOSURE, ONI_STREAM_PROPERTY_AUTO_WHITE_BALANCE}) {
    if (oniStreamIsPropertySupported(colour_.handle, id) == FALSE) continue;
    oniStreamSetProperty(colour_.handle, id, &is_automatic, sizeof(is_automatic));
  }
}

Result<void> OpenNi2Camera::set_control(DeviceControl control, int value) {
  if (control != DeviceControl::kColourAutomatics || !colour_.chosen) {
    return Error{ErrorCode::kDevice, "the camera has no such control", info_.uri};
  }
  hold_automatics(value == 0);
  return {};
}

Result<std::vector<DeviceInfo>> list_cameras_here() {
  const OpenNi library;
  OniDeviceInfo* devices = nullptr;
  int count = 0;
  if (!library.is_started() || oniGetDeviceList(&devices, &count) != ONI_STATUS_OK) {
    return failed("OpenNI2 does not start", "openni2:");
  }
  std::vector<DeviceInfo> cameras;
  for (int i = 0; i < count; ++i) cameras.push_back(describe(devices[i]));
  oniReleaseDeviceList(devices);
  return cameras;
}

}  // namespace

Result<std::vector<DeviceInfo>> list_openni2_cameras() {
  std::optional<Result<std::vector<DeviceInfo>>> cameras;
  do_on_library_thread([&] { cameras = list_cameras_here(); });
  return *std::move(cameras);
}

Result<std::unique_ptr<DeviceSource>> open_openni2_camera(const std::string& uri, const DeviceOptions& options) {
  DeviceInfo info;
  info.uri = uri;
  info.name = "OpenNI2 camera";
  info.support = "should work";
  std::unique_ptr<OpenNi2Camera> camera;
  Result<void> opened;
  do_on_library_thread([&] {
    camera = std::make_unique<OpenNi2Camera>(std::move(info), options);
    opened = camera->open();
    if (!opened) camera.reset();
  });
  if (!opened) return opened.error();
  return on_library_thread(std::move(camera));
}

}  // namespace scanknit
