// A driver for OpenNI2 without a camera behind it: one device that serves emulated_pictures.h, 30 times a second. The
// library loads it from its folder of drivers as it loads those of real cameras.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)

#include <Driver/OniDriverAPI.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string>
#include <thread>

#include "tests/openni2/emulated_driver.h"
#include "tests/openni2/emulated_pictures.h"

namespace scanknit::test {
namespace {

constexpr int kFramesPerSecond = 30;

enum class Silence { kNone, kUntilStarted, kUntilOpened, kOfColour };
std::atomic<Silence> the_silence = Silence::kNone;

OniDeviceInfo device_info() {
  OniDeviceInfo info{};
  std::strcpy(info.uri, kEmulatedUri);
  std::strcpy(info.vendor, "ScanKnit");
  std::strcpy(info.name, "emulated camera");
  return info;
}

OniVideoMode mode_of(OniSensorType sensor) {
  const bool is_depth = sensor == ONI_SENSOR_DEPTH;
  return {is_depth ? ONI_PIXEL_FORMAT_DEPTH_1_MM : ONI_PIXEL_FORMAT_RGB888, kEmulatedCamera.width,
          kEmulatedCamera.height, kFramesPerSecond};
}

/// A property's value goes out when its size is the expected one.
template <typename T>
OniStatus give(const T& value, void* data, int* size) {
  if (*size != static_cast<int>(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof(T));
  return ONI_STATUS_OK;
}

class EmulatedStream final : public oni::driver::StreamBase {
 public:
  explicit EmulatedStream(OniSensorType sensor) : sensor_(sensor) {}
  ~EmulatedStream() override { EmulatedStream::stop(); }

  OniStatus start() override {
    (void)emulated_picture(0);  // rendered before the clock runs
    Silence until_started = Silence::kUntilStarted;
    the_silence.compare_exchange_strong(until_started, Silence::kNone);
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
    return ONI_STATUS_OK;
  }
  void stop() override { thread_ = {}; }

  OniBool isPropertySupported(int id) override {
    return id == ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV ||
           id == ONI_STREAM_PROPERTY_VERTICAL_FOV || id == ONI_STREAM_PROPERTY_MIRRORING ||
           id == ONI_STREAM_PROPERTY_MAX_VALUE || id == ONI_STREAM_PROPERTY_CROPPING;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    const auto view = [](int pixels, double focal) { return static_cast<float>(2 * std::atan(pixels / (2 * focal))); };
    switch (id) {
      case ONI_STREAM_PROPERTY_VIDEO_MODE: return give(mode_of(sensor_), data, size);
      case ONI_STREAM_PROPERTY_HORIZONTAL_FOV: return give(view(kEmulatedCamera.width, kEmulatedCamera.fx), data, size);
      case ONI_STREAM_PROPERTY_VERTICAL_FOV: return give(view(kEmulatedCamera.height, kEmulatedCamera.fy), data, size);
      case ONI_STREAM_PROPERTY_MIRRORING: return give(is_mirrored_.load() ? TRUE : FALSE, data, size);
      case ONI_STREAM_PROPERTY_MAX_VALUE: return give(10'000, data, size);
      case ONI_STREAM_PROPERTY_CROPPING: return give(OniCropping{}, data, size);  // the player shows nothing without it
      default: return ONI_STATUS_NOT_SUPPORTED;
    }
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) return ONI_STATUS_OK;  // there is one only
    OniBool is_on = FALSE;
    if (id != ONI_STREAM_PROPERTY_MIRRORING || size != static_cast<int>(sizeof(is_on))) return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(&is_on, data, sizeof(is_on));
    is_mirrored_ = is_on != FALSE;
    return ONI_STATUS_OK;
  }

 private:
  void run(const std::stop_token& stop) {
    const auto begin = std::chrono::steady_clock::now();
    for (int n = 0; !stop.stop_requested(); ++n) {
      std::this_thread::sleep_until(begin + std::chrono::microseconds(n * 1'000'000ll / kFramesPerSecond));
      const Silence silence = the_silence;
      const bool is_mine = silence != Silence::kOfColour || sensor_ == ONI_SENSOR_COLOR;
      if (silence != Silence::kNone && is_mine) continue;
      if (OniFrame* frame = getServices().acquireFrame()) {
        fill(*frame, n);
        raiseNewFrame(frame);
        getServices().releaseFrame(frame);
      }
    }
  }

  void fill(OniFrame& frame, int n) const {
    const EmulatedPicture& picture = emulated_picture(emulated_at(static_cast<std::size_t>(n)));
    const bool is_depth = sensor_ == ONI_SENSOR_DEPTH;
    const std::size_t pixel_bytes = is_depth ? 2 : 3;
    frame.frameIndex = n + 1;
    frame.timestamp = static_cast<std::uint64_t>(n) * 1'000'000 / kFramesPerSecond;
    frame.sensorType = sensor_;
    frame.videoMode = mode_of(sensor_);
    frame.width = kEmulatedCamera.width;
    frame.height = kEmulatedCamera.height;
    frame.croppingEnabled = FALSE;
    frame.cropOriginX = frame.cropOriginY = 0;
    frame.stride = frame.width * static_cast<int>(pixel_bytes);
    frame.dataSize = frame.stride * frame.height;
    const void* bytes = is_depth ? static_cast<const void*>(picture.depth_mm.data()) : picture.rgb.data();
    std::memcpy(frame.data, bytes, static_cast<std::size_t>(frame.dataSize));
    if (is_mirrored_) mirror(frame, pixel_bytes);
  }

  static void mirror(const OniFrame& frame, std::size_t pixel_bytes) {
    auto* bytes = static_cast<char*>(frame.data);
    const auto width = static_cast<std::size_t>(frame.width);
    for (int y = 0; y < frame.height; ++y, bytes += frame.stride) {
      for (std::size_t x = 0; x < width / 2; ++x) {
        std::swap_ranges(bytes + x * pixel_bytes, bytes + (x + 1) * pixel_bytes, bytes + (width - 1 - x) * pixel_bytes);
      }
    }
  }

  const OniSensorType sensor_;
  std::atomic<bool> is_mirrored_ = true;  // as the drivers of real cameras begin
  std::jthread thread_;
};

class EmulatedDevice final : public oni::driver::DeviceBase {
 public:
  OniStatus getSensorInfoList(OniSensorInfo** infos, int* count) override {
    *infos = sensors_;
    *count = 2;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType sensor) override { return new EmulatedStream(sensor); }
  void destroyStream(oni::driver::StreamBase* stream) override { delete stream; }

  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode) override { return TRUE; }
  OniBool isPropertySupported(int id) override { return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION; }
  OniStatus setProperty(int id, const void*, int) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
  }

 private:
  OniVideoMode modes_[2] = {mode_of(ONI_SENSOR_DEPTH), mode_of(ONI_SENSOR_COLOR)};
  OniSensorInfo sensors_[2] = {{ONI_SENSOR_DEPTH, 1, &modes_[0]}, {ONI_SENSOR_COLOR, 1, &modes_[1]}};
};

class EmulatedDriver;
EmulatedDriver* the_driver = nullptr;  // whom plug() and unplug() tell

class EmulatedDriver final : public oni::driver::DriverBase {
 public:
  explicit EmulatedDriver(OniDriverServices* services) : DriverBase(services) { the_driver = this; }
  ~EmulatedDriver() override { the_driver = nullptr; }

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    plug();
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char*, const char*) override {
    the_silence = Silence::kNone;
    return new EmulatedDevice;
  }
  void deviceClose(oni::driver::DeviceBase* device) override { delete device; }
  void shutdown() override {}

  void plug() {
    const OniDeviceInfo info = device_info();
    deviceConnected(&info);
  }
  void unplug() {
    const OniDeviceInfo info = device_info();
    deviceDisconnected(&info);
  }
};

}  // namespace
}  // namespace scanknit::test

using scanknit::test::EmulatedDriver;
ONI_EXPORT_DRIVER(EmulatedDriver)

extern "C" {
__attribute__((visibility("default"))) void scanknit_emulated_fall_silent() {
  scanknit::test::the_silence = scanknit::test::Silence::kUntilStarted;
}
__attribute__((visibility("default"))) void scanknit_emulated_stay_silent() {
  scanknit::test::the_silence = scanknit::test::Silence::kUntilOpened;
}
__attribute__((visibility("default"))) void scanknit_emulated_lose_colour() {
  scanknit::test::the_silence = scanknit::test::Silence::kOfColour;
}
__attribute__((visibility("default"))) void scanknit_emulated_plug() {
  if (scanknit::test::the_driver != nullptr) scanknit::test::the_driver->plug();
}
__attribute__((visibility("default"))) void scanknit_emulated_unplug() {
  if (scanknit::test::the_driver != nullptr) scanknit::test::the_driver->unplug();
}
}
