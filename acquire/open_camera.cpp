#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <tuple>

#include "acquire/device_source.h"
#include "acquire/kinect1/kinect1_camera.h"
#include "acquire/openni2/openni2_plugin.h"
#include "acquire/reconnecting_source.h"
#include "acquire/usb/usb_context.h"
#include "acquire/usb/usb_numbers.h"
#include "acquire/uvc/uvc_camera.h"
#include "acquire/uvc/uvc_descriptors.h"
#include "acquire/waiting.h"

namespace scanknit {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr double kMjpegRatio = 0.1;

constexpr std::string_view kUsb = "usb:", kKinect = "kinect1:";

enum class Driver { kUvc, kKinect1 };

/// A scanner that is plugged in.
struct FoundCamera {
  Driver driver;
  UsbDeviceInfo usb;
  DeviceInfo info;
  std::string numbered_uri;  ///< "kinect1:1", also of one that has a serial number; empty for other drivers
};

/// What a URI asks for: what is not said fits every scanner.
struct WantedCamera {
  std::optional<Driver> driver;
  std::optional<UsbNumbers> numbers;
  std::string serial;
  std::string exact_uri;

  [[nodiscard]] bool fits(const FoundCamera& camera) const {
    return (!driver || *driver == camera.driver) &&
           (!numbers || *numbers == UsbNumbers{camera.usb.vendor, camera.usb.product}) &&
           (serial.empty() || serial == camera.info.serial) &&
           (exact_uri.empty() || exact_uri == camera.info.uri || exact_uri == camera.numbered_uri);
  }
};

std::optional<WantedCamera> parse_uri(std::string_view uri) {
  WantedCamera wanted;
  if (uri.empty()) return wanted;
  if (uri.starts_with(kKinect)) {
    wanted.driver = Driver::kKinect1;
    if (uri != kKinect) wanted.exact_uri = uri;
    return wanted;
  }
  if (!uri.starts_with(kUsb)) return std::nullopt;
  wanted.driver = Driver::kUvc;
  uri.remove_prefix(kUsb.size());
  if (uri.empty()) return wanted;
  if (const auto slash = uri.find('/'); slash != std::string_view::npos) {
    wanted.serial = uri.substr(slash + 1);
    uri = uri.substr(0, slash);
  }
  wanted.numbers = parse_usb_numbers(uri);
  if (!wanted.numbers) return std::nullopt;
  return wanted;
}

std::vector<FoundCamera> find_cameras(const UsbContext& context) {
  std::vector<FoundCamera> cameras;
  int kinects = 0;
  for (UsbDeviceInfo& device : context.devices()) {
    if (is_kinect1(device)) {
      const std::string numbered_uri = std::string(kKinect) + std::to_string(kinects);
      const DeviceInfo info = describe_kinect1(device, kinects++);
      cameras.push_back({Driver::kKinect1, std::move(device), info, numbered_uri});
    } else if (!depth_functions_of(device).empty()) {
      const DeviceInfo info = describe_camera(device);
      cameras.push_back({Driver::kUvc, std::move(device), info, ""});
    }
  }
  return cameras;
}

Result<std::unique_ptr<DeviceSource>> open_found(UsbContext& context, const FoundCamera& camera,
                                                 const DeviceOptions& options, const std::stop_token& stop) {
  if (camera.driver == Driver::kUvc) return open_uvc_camera(context, camera.usb, options, stop);
  return open_kinect1(camera.usb, camera.info, options);
}

std::string why_not_found(const std::vector<FoundCamera>& cameras) {
  if (cameras.empty()) return "no depth camera is plugged in";
  std::string why = "no such camera is plugged in, but";
  for (const FoundCamera& camera : cameras) why += (&camera == &cameras.front() ? " " : ", ") + camera.info.uri;
  return why + (cameras.size() > 1 ? " are" : " is");
}

/// Looks until it is there, or until the deadline, or a stop. A camera that has just been plugged in may be forbidden
/// or busy for a moment, while the system still sets it up: it is tried again.
Result<std::unique_ptr<DeviceSource>> wait_and_open(UsbContext& context, const WantedCamera& wanted,
                                                    const DeviceOptions& options, Clock::time_point deadline,
                                                    const std::stop_token& stop) {
  constexpr milliseconds kAgain{100};
  while (true) {
    const std::uint64_t seen = context.generation();
    const auto cameras = find_cameras(context);
    const auto found =
        std::find_if(cameras.begin(), cameras.end(), [&](const FoundCamera& camera) { return wanted.fits(camera); });
    Result<std::unique_ptr<DeviceSource>> opened = Error{ErrorCode::kDevice, why_not_found(cameras)};
    if (found != cameras.end()) opened = open_found(context, *found, options, stop);
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - Clock::now());
    if (opened || left <= milliseconds(0) || stop.stop_requested()) return opened;
    const milliseconds most = found != cameras.end() ? kAgain : milliseconds(1000);
    context.wait_for_change(seen, std::min(left, most), stop);
  }
}

}  // namespace

Result<std::vector<DeviceInfo>> list_cameras() {
  const auto context = UsbContext::create();
  if (!context) return context.error();
  std::vector<DeviceInfo> cameras;
  for (FoundCamera& camera : find_cameras(**context)) cameras.push_back(std::move(camera.info));
  auto others = list_openni2();
  std::move(others.begin(), others.end(), std::back_inserter(cameras));
  return cameras;
}

Result<std::unique_ptr<DeviceSource>> open_camera(const std::string& uri, const DeviceOptions& options,
                                                  std::stop_token stop) {
  if (uri.starts_with(kOpenNi2Prefix)) return open_openni2(uri, options, stop);
  const auto wanted = parse_uri(uri);
  if (!wanted) {
    return Error{ErrorCode::kUsage, "'" + uri +
                                        "' names no device; expected usb:, usb:8086:0b07, usb:8086:0b07/SERIAL, "
                                        "kinect1:0, kinect1:SERIAL or openni2:"};
  }
  auto created = UsbContext::create();
  if (!created) return created.error();
  const std::shared_ptr<UsbContext> context = *created;
  // A module's camera is taken unnamed when there is no other.
  if (uri.empty() && find_cameras(*context).empty() && !list_openni2().empty()) {
    return open_openni2(kOpenNi2Prefix, options, stop);
  }
  auto opened = wait_and_open(*context, *wanted, options, after(options.wait_s), stop);
  if (!opened || options.reconnect_s <= 0) return opened;
  // The same camera again, by its serial number; one without is known by its kind.
  const WantedCamera same = *parse_uri((*opened)->info().uri);
  auto reopen = [context, same, options](const std::stop_token& give_up) {
    return wait_and_open(*context, same, options, after(options.reconnect_s), give_up);
  };
  return make_reconnecting(std::move(*opened), std::move(reopen),
                           std::chrono::duration_cast<milliseconds>(after(options.reconnect_s) - Clock::now()));
}

std::vector<StreamProfile> choose_streams(std::span<const StreamProfile> profiles, int width, int height,
                                          double frames_per_second, PixelFormat depth_format) {
  const auto nearest = [&](StreamKind kind, double rate) -> const StreamProfile* {
    const auto cost = [&](const StreamProfile& p) {
      const double size_error = std::abs(std::log(static_cast<double>(p.width) * p.height / (1.0 * width * height)));
      return std::tuple(p.width < width || p.height < height, size_error, std::abs(p.frames_per_second - rate),
                        p.format == PixelFormat::kMjpeg);
    };
    const StreamProfile* best = nullptr;
    for (const StreamProfile& p : profiles) {
      const bool is_wanted = p.kind == kind && (kind != StreamKind::kDepth || p.format == depth_format);
      if (is_wanted && (best == nullptr || cost(p) < cost(*best))) best = &p;
    }
    return best;
  };
  const StreamProfile* depth = nearest(StreamKind::kDepth, frames_per_second);
  if (depth == nullptr) return {};
  std::vector<StreamProfile> chosen = {*depth};
  if (const StreamProfile* colour = nearest(StreamKind::kColour, depth->frames_per_second)) chosen.push_back(*colour);
  return chosen;
}

double bandwidth_of(std::span<const StreamProfile> streams) {
  double sum = 0;
  for (const StreamProfile& p : streams) {
    const double raw = 2.0 * p.width * p.height * p.frames_per_second;
    sum += picture_bytes(p.format, p.width, p.height) ? raw : kMjpegRatio * raw;
  }
  return sum;
}

}  // namespace scanknit
