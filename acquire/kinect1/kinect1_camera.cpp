#include "acquire/kinect1/kinect1_camera.h"

#include <libfreenect.h>
#include <libusb-1.0/libusb.h>
#include <pthread.h>
#include <sys/time.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "acquire/kinect1/bounded_requests.h"
#include "acquire/silence_watch.h"
#include "acquire/steady_now.h"
#include "acquire/usb/clock_map.h"

namespace scanknit {
namespace {

constexpr std::uint16_t kXboxCamera = kKinect1Products[0];
constexpr int kWidth = 640, kHeight = 480;
constexpr std::size_t kPixels = static_cast<std::size_t>(kWidth) * kHeight;
constexpr std::uint32_t kTicksPerSecond = 60'000'000;
constexpr double kNominalFocal = 525;  // of the colour camera, pixels; single Kinects differ by a percent
constexpr auto kBeforeHolding = std::chrono::milliseconds(1000);
// For the requests of one step together, some dozens, and for each: a Kinect answers in milliseconds, a virtual machine
// takes a hundred times as long.
constexpr std::chrono::milliseconds kToStart(10'000), kEachToStart(1000);
constexpr std::chrono::milliseconds kToStop(5000), kEachToStop(400);  // the first that is not answered is the last
constexpr std::chrono::milliseconds kEachWhileStreaming(400);         // a stop waits for it

constexpr StreamProfile kDepthProfile{StreamKind::kDepth, PixelFormat::kZ16, kWidth, kHeight, 30};
constexpr StreamProfile kColourProfile{StreamKind::kColour, PixelFormat::kRgb8, kWidth, kHeight, 30};

bool is_kinect1_camera(std::uint16_t vendor, std::uint16_t product) {
  const bool is_product =
      std::find(kKinect1Products.begin(), kKinect1Products.end(), product) != kKinect1Products.end();
  return vendor == kKinect1Vendor && is_product;
}

/// One of the Kinect's two pictures. libfreenect hands over pictures with packets missing as if they were whole; it
/// hands over each packet, too, when asked, and so they are counted.
struct KinectStream {
  StreamProfile profile;
  std::size_t packet_bytes;  ///< of the picture, in one packet
  std::size_t raw_bytes;     ///< of the picture, as the Kinect sends it
  std::vector<std::byte> buffer;
  std::size_t received = 0;
  std::uint64_t sequence = 0;
  std::optional<DeviceClock> clock = std::nullopt;  ///< since the stream was started
  std::int64_t last_good_ns = 0;
  std::uint64_t damaged = 0;  ///< since then
  bool is_wanted = false;
  SilenceWatch watch{0};  ///< since the stream was started

  [[nodiscard]] std::string name() const { return profile.kind == StreamKind::kDepth ? "depth" : "colour"; }

  void take(void* raw, const void* data, int packet, int bytes) {
    if (packet < 0 || bytes < 0) return;
    const std::size_t at = static_cast<std::size_t>(packet) * packet_bytes;
    const auto size = static_cast<std::size_t>(bytes);
    if (at > raw_bytes || size > raw_bytes - at) return;
    std::memcpy(static_cast<std::byte*>(raw) + at, data, size);
    received += size;
  }
};

/// libfreenect, on a USB context of ours: so it is known in which order it sees the Kinects.
class FreenectContext {
 public:
  FreenectContext() {
    if (libusb_init(&usb_) != 0) usb_ = nullptr;
    if (usb_ == nullptr || freenect_init(&context_, usb_) < 0) context_ = nullptr;
    if (context_ == nullptr) return;
    freenect_set_log_level(context_, FREENECT_LOG_FATAL);
    freenect_select_subdevices(context_, FREENECT_DEVICE_CAMERA);
  }
  ~FreenectContext() {
    const BoundedRequests in_time(kToStop, kEachToStop);
    if (context_ != nullptr) freenect_shutdown(context_);
    if (usb_ != nullptr) libusb_exit(usb_);
  }
  FreenectContext(const FreenectContext&) = delete;
  FreenectContext& operator=(const FreenectContext&) = delete;

  [[nodiscard]] freenect_context* get() const { return context_; }  ///< null: USB cannot be used

  /// The Kinect at that place, or null. libfreenect takes an index only: by serial number too it looks for an index,
  /// and counts wrongly when one of them cannot be opened.
  [[nodiscard]] freenect_device* open(const UsbDeviceInfo& wanted) {
    constexpr int kAttempts = 5;  // another Kinect may come or go at this very moment
    const BoundedRequests in_time(kToStart, kEachToStart);
    for (int i = 0; i < kAttempts; ++i) {
      const auto before = kinects();
      const auto found = std::find(before.begin(), before.end(), std::pair(wanted.bus, wanted.address));
      freenect_device* device = nullptr;
      const auto index = static_cast<int>(found - before.begin());
      if (found == before.end() || freenect_open_device(context_, &device, index) < 0) return nullptr;
      if (kinects() == before) return device;
      freenect_close_device(device);
    }
    return nullptr;
  }

 private:
  /// Bus and address of each, in libfreenect's order.
  [[nodiscard]] std::vector<std::pair<int, int>> kinects() const {
    libusb_device** devices = nullptr;
    const ssize_t count = libusb_get_device_list(usb_, &devices);
    std::vector<std::pair<int, int>> found;
    for (libusb_device* device : std::span(devices, count > 0 ? static_cast<std::size_t>(count) : 0)) {
      libusb_device_descriptor descriptor{};
      if (libusb_get_device_descriptor(device, &descriptor) != 0) continue;
      if (!is_kinect1_camera(descriptor.idVendor, descriptor.idProduct)) continue;
      found.emplace_back(libusb_get_bus_number(device), libusb_get_device_address(device));
    }
    if (devices != nullptr) libusb_free_device_list(devices, 1);
    return found;
  }

  libusb_context* usb_ = nullptr;
  freenect_context* context_ = nullptr;
};

class Kinect1Camera final : public DeviceSource {
 public:
  Kinect1Camera(DeviceInfo info, const DeviceOptions& options, std::unique_ptr<FreenectContext> context,
                freenect_device* device)
      : info_(std::move(info)), options_(options), context_(std::move(context)), device_(device) {
    freenect_set_user(device_, this);
    freenect_set_depth_mode(device_, freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_DEPTH_REGISTERED));
    freenect_set_video_mode(device_, freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB));
    freenect_set_depth_chunk_callback(device_, [](void* raw, void* data, int packet, int bytes, void* self) {
      static_cast<Kinect1Camera*>(self)->depth_.take(raw, data, packet, bytes);
    });
    freenect_set_video_chunk_callback(device_, [](void* raw, void* data, int packet, int bytes, void* self) {
      static_cast<Kinect1Camera*>(self)->colour_.take(raw, data, packet, bytes);
    });
    freenect_set_depth_callback(device_, [](freenect_device* sender, void*, std::uint32_t ticks) {
      auto& self = *static_cast<Kinect1Camera*>(freenect_get_user(sender));
      self.finish(self.depth_, ticks);
    });
    freenect_set_video_callback(device_, [](freenect_device* sender, void*, std::uint32_t ticks) {
      auto& self = *static_cast<Kinect1Camera*>(freenect_get_user(sender));
      self.finish(self.colour_, ticks);
    });
  }
  ~Kinect1Camera() override {
    stop();
    const BoundedRequests in_time(kToStop, kEachToStop);
    freenect_close_device(device_);
  }

  [[nodiscard]] const DeviceInfo& info() const override { return info_; }
  [[nodiscard]] std::vector<StreamProfile> profiles() const override { return {kDepthProfile, kColourProfile}; }
  [[nodiscard]] Result<RawCalibration> calibration(std::span<const StreamProfile> streams) override;
  [[nodiscard]] Result<void> start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) override;
  void stop() override;
  [[nodiscard]] LossCounters losses() const override {
    const std::lock_guard lock(mutex_);
    return losses_;
  }
  [[nodiscard]] Result<void> set_control(DeviceControl control, int value) override;

 private:
  [[nodiscard]] bool start_streams();
  void stop_streams();
  void run(const std::stop_token& stop);
  [[nodiscard]] bool look_at(KinectStream& stream);
  [[nodiscard]] bool give_up(KinectStream& stream, const std::string& complaint);
  void restart(const KinectStream& stream);
  void finish(KinectStream& stream, std::uint32_t ticks);
  void hold_automatics(bool is_held);
  void tell(DeviceEvent::Kind kind, const std::string& text) { events_({kind, info_.name + ": " + text}); }

  const DeviceInfo info_;
  const DeviceOptions options_;
  std::unique_ptr<FreenectContext> context_;
  freenect_device* device_;
  // libfreenect's packets: 1760 and 1920 bytes, 12 of them a header. Depth is packed, 11 bits a pixel; colour is Bayer.
  KinectStream depth_{kDepthProfile, 1748, kPixels * 11 / 8, std::vector<std::byte>(2 * kPixels)};
  KinectStream colour_{kColourProfile, 1908, kPixels, std::vector<std::byte>(3 * kPixels)};
  FrameSink frames_;
  EventSink events_;
  bool is_holding_ = false;
  mutable std::mutex mutex_;  // of losses_
  LossCounters losses_;
  std::jthread thread_;
};

Result<RawCalibration> Kinect1Camera::calibration(std::span<const StreamProfile> streams) {
  RawCalibration calibration;
  calibration.device = info_.name;
  calibration.serial = info_.serial;
  calibration.depth_unit_m = options_.depth_scale ? 1 / *options_.depth_scale : 0.001;
  const CameraIntrinsics nominal{
      kWidth, kHeight, kNominalFocal, kNominalFocal, (kWidth - 1) / 2.0, (kHeight - 1) / 2.0};
  calibration.depth = options_.intrinsics.value_or(CameraModel{nominal, {}});
  if (calibration.depth.intrinsics.width == 0) {
    calibration.depth.intrinsics.width = kWidth;
    calibration.depth.intrinsics.height = kHeight;
  }
  calibration.source = options_.intrinsics ? "acquire.intrinsics" : "nominal values of a Kinect";
  const bool has_colour =
      std::any_of(streams.begin(), streams.end(), [](const StreamProfile& p) { return p.kind == StreamKind::kColour; });
  if (has_colour) calibration.colour = calibration.depth;  // depth is moved into the colour camera
  return calibration;
}

Result<void> Kinect1Camera::start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) {
  if (thread_.joinable()) return Error{ErrorCode::kDevice, "the camera streams already", info_.name};
  frames_ = std::move(frames);
  events_ = std::move(events);
  losses_ = {};
  for (KinectStream* stream : {&depth_, &colour_}) {
    stream->is_wanted = std::find(streams.begin(), streams.end(), stream->profile) != streams.end();
    stream->sequence = stream->damaged = 0;
    stream->last_good_ns = 0;
    stream->clock.emplace(kTicksPerSecond);
  }
  freenect_set_depth_buffer(device_, depth_.buffer.data());
  freenect_set_video_buffer(device_, colour_.buffer.data());
  const BoundedRequests in_time(kToStart, kEachToStart);
  if (!start_streams()) {
    stop_streams();
    return Error{ErrorCode::kDevice, "the camera does not start. Re-plug it, its power supply too", info_.name};
  }
  thread_ = std::jthread([this](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "usb");
    run(stop);
  });
  return {};
}

void Kinect1Camera::stop() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  thread_ = {};
  const BoundedRequests in_time(kToStop, kEachToStop);
  if (std::exchange(is_holding_, false)) hold_automatics(false);
  stop_streams();
}

bool Kinect1Camera::start_streams() {
  depth_.received = colour_.received = 0;
  return (!depth_.is_wanted || freenect_start_depth(device_) >= 0) &&
         (!colour_.is_wanted || freenect_start_video(device_) >= 0);
}

void Kinect1Camera::stop_streams() {
  freenect_stop_depth(device_);
  freenect_stop_video(device_);
}

void Kinect1Camera::run(const std::stop_token& stop) {
  const auto started = std::chrono::steady_clock::now();
  depth_.watch = colour_.watch = SilenceWatch(steady_now_ns());
  while (!stop.stop_requested()) {
    timeval at_most{0, 100'000};
    if (freenect_process_events_timeout(context_->get(), &at_most) < 0)
      return tell(DeviceEvent::Kind::kLeft, "unplugged");
    const auto now = std::chrono::steady_clock::now();
    const BoundedRequests in_time(kToStart, kEachWhileStreaming, stop);
    if (!look_at(depth_) || !look_at(colour_)) return;
    if (options_.holds_automatics && !is_holding_ && now - started > kBeforeHolding) {
      is_holding_ = true;
      hold_automatics(true);
    }
  }
}

/// False: the camera was given up.
bool Kinect1Camera::look_at(KinectStream& stream) {
  if (!stream.is_wanted) return true;
  const auto verdict = stream.watch.look(stream.last_good_ns, steady_now_ns());
  if (verdict == SilenceWatch::Verdict::kNothing) return true;
  if (verdict == SilenceWatch::Verdict::kRecovered)
    return tell(DeviceEvent::Kind::kRecovered, "frames come again"), true;
  const std::string came = stream.damaged == 0 ? "no " + stream.name() + " comes"
                                               : "no good " + stream.name() + " comes, but " +
                                                     std::to_string(stream.damaged) + " damaged pictures did";
  const std::string complaint = came + ". Check its cable and power supply";
  if (verdict == SilenceWatch::Verdict::kGiveUp) return give_up(stream, complaint);
  if (stream.watch.restarts() == 1) {
    tell(stream.damaged == 0 ? DeviceEvent::Kind::kSilent : DeviceEvent::Kind::kDamaged, complaint);
  }
  restart(stream);
  return true;
}

/// Without depth there is nothing to scan; without colour there is.
bool Kinect1Camera::give_up(KinectStream& stream, const std::string& complaint) {
  const std::string why = complaint + "; it was started " + std::to_string(stream.watch.restarts()) +
                          " times again without a good picture. ";
  if (&stream == &colour_ && depth_.is_wanted) {
    freenect_stop_video(device_);
    colour_.is_wanted = false;
    tell(DeviceEvent::Kind::kNoColour, why + kGoesOnWithoutColour);
    return true;
  }
  tell(DeviceEvent::Kind::kFailed, why + "Re-plug it");
  return false;
}

/// Colour alone where depth is well. What does not start stays silent.
void Kinect1Camera::restart(const KinectStream& stream) {
  if (&stream == &colour_) {
    freenect_stop_video(device_);
    colour_.received = 0;
    (void)freenect_start_video(device_);
  } else {
    stop_streams();
    (void)start_streams();
    depth_.watch.restarted(steady_now_ns());
  }
  colour_.watch.restarted(steady_now_ns());
}

void Kinect1Camera::finish(KinectStream& stream, std::uint32_t ticks) {
  const std::int64_t host_ns = steady_now_ns();
  const std::uint64_t sequence = stream.sequence++;
  if (std::exchange(stream.received, 0) != stream.raw_bytes) {
    ++stream.damaged;
    const std::lock_guard lock(mutex_);
    ++losses_.transport;
    return;
  }
  stream.last_good_ns = host_ns;
  stream.damaged = 0;
  const DeviceClock::Stamp stamp = stream.clock->stamp(ticks, host_ns);
  auto bytes = std::make_shared<const std::vector<std::byte>>(stream.buffer);
  frames_({stream.profile, sequence, stamp.device_ns, host_ns, std::move(bytes)});
}

void Kinect1Camera::hold_automatics(bool is_held) {
  const auto value = is_held ? FREENECT_OFF : FREENECT_ON;
  freenect_set_flag(device_, FREENECT_AUTO_EXPOSURE, value);
  freenect_set_flag(device_, FREENECT_AUTO_WHITE_BALANCE, value);
}

Result<void> Kinect1Camera::set_control(DeviceControl control, int value) {
  if (control != DeviceControl::kColourAutomatics) {
    return Error{ErrorCode::kDevice, "the camera has no such control", info_.name};
  }
  const BoundedRequests in_time(kToStart, kEachToStart);
  hold_automatics(value == 0);
  return {};
}

}  // namespace

bool is_kinect1(const UsbDeviceInfo& device) {
  return is_kinect1_camera(device.vendor, device.product);
}

DeviceInfo describe_kinect1(const UsbDeviceInfo& device, int index) {
  DeviceInfo info;
  if (device.serial.find_first_not_of('0') != std::string::npos) info.serial = device.serial;
  info.uri = "kinect1:" + (info.serial.empty() ? std::to_string(index) : info.serial);
  info.name = device.product == kXboxCamera ? "Kinect for Xbox 360" : "Kinect for Windows v1";
  info.bus = device.bus;
  info.address = device.address;
  info.speed_mbit = device.speed_mbit;
  info.support = device.product == kXboxCamera ? "tested on an emulated device" : "should work";
  return info;
}

Result<std::unique_ptr<DeviceSource>> open_kinect1(const UsbDeviceInfo& usb, DeviceInfo info,
                                                   const DeviceOptions& options) {
  if (!options.takes_from_others) {
    if (const auto free = refuse_if_used(usb); !free) return free.error();
  }
  auto context = std::make_unique<FreenectContext>();
  if (context->get() == nullptr) return Error{ErrorCode::kDevice, "libfreenect cannot use USB", info.name};
  freenect_device* device = context->open(usb);
  if (device == nullptr) {
    return Error{ErrorCode::kDevice, "cannot open " + usb.place() + "; a Kinect needs its power supply, too",
                 info.name};
  }
  return std::unique_ptr<DeviceSource>(
      std::make_unique<Kinect1Camera>(std::move(info), options, std::move(context), device));
}

}  // namespace scanknit
