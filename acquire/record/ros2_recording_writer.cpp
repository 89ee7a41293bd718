#include "acquire/record/ros2_recording_writer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

#include "acquire/mcap/byte_appender.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::size_t kRos2ChunkBytes = 4u << 20;
constexpr std::int64_t kRos2ChunkPeriod_ns = 400'000'000;
constexpr std::int64_t kTransformPeriod_ns = 10'000'000'000;
constexpr std::int64_t kClockJump_ns = 100'000'000;  // the camera's clock began again

bool is_mjpeg(std::span<const StreamProfile> streams) {
  return std::any_of(streams.begin(), streams.end(),
                     [](const StreamProfile& s) { return s.format == PixelFormat::kMjpeg; });
}

template <typename Clock>
std::int64_t now_ns() {
  return std::chrono::nanoseconds(Clock::now().time_since_epoch()).count();
}

/// By sensor_msgs/image_encodings.h.
const char* encoding_of(PixelFormat format) {
  switch (format) {
    case PixelFormat::kZ16: return "16UC1";
    case PixelFormat::kYuyv: return "yuv422_yuy2";
    case PixelFormat::kUyvy: return "yuv422";
    case PixelFormat::kBgr8: return "bgr8";
    case PixelFormat::kRgb8:
    case PixelFormat::kMjpeg:
    case PixelFormat::kY8i: break;
  }
  return "rgb8";
}

/// Depth in metres, 32-bit floats, NaN where there is none.
std::vector<std::byte> metres_of(std::span<const std::byte> z16, double unit_m) {
  std::vector<std::byte> pixels;
  pixels.reserve(2 * z16.size());
  ByteAppender appender(pixels);
  for (ByteReader reader(z16); reader.remaining() >= sizeof(std::uint16_t);) {
    const auto raw = reader.little_endian<std::uint16_t>().value_or(0);
    appender.little_endian(raw > 0 ? static_cast<float>(raw * unit_m) : std::numeric_limits<float>::quiet_NaN());
  }
  return pixels;
}

}  // namespace

Ros2RecordingWriter::Ros2RecordingWriter(ByteSink sink, RawCalibration calibration,
                                         std::span<const StreamProfile> streams)
    : bag_(std::move(sink), {"/camera/depth/image_raw", is_mjpeg(streams)}),
      calibration_(std::move(calibration)),
      day_minus_host_ns_(now_ns<std::chrono::system_clock>() - now_ns<std::chrono::steady_clock>()) {}

Result<void> Ros2RecordingWriter::write(const RawFrame& frame) {
  set_time(frame);
  const bool has_transform = calibration_.depth.intrinsics.width > 0 && calibration_.colour.intrinsics.width > 0;
  if (has_transform && (!transform_at_ns_ || frame.host_ns - *transform_at_ns_ >= kTransformPeriod_ns)) {
    bag_.add_transform(Ros2Topic::kTfStatic, kRos2DepthFrame, kRos2ColourFrame, calibration_.T_colour_depth.inverse());
    transform_at_ns_ = frame.host_ns;
  }
  if (frame.profile.kind == StreamKind::kDepth) {
    add_depth(frame);
  } else {
    add_colour(frame);
  }
  if (frames_waiting_++ == 0) chunk_begin_ns_ = frame.host_ns;
  const bool is_full =
      bag_.waiting_bytes() >= kRos2ChunkBytes || frame.host_ns - chunk_begin_ns_ >= kRos2ChunkPeriod_ns;
  return is_full ? flush() : Result<void>{};
}

/// A picture's stamp is the camera's own time, moved to the time of day once; else that of its arrival.
void Ros2RecordingWriter::set_time(const RawFrame& frame) {
  const std::int64_t arrived_ns = frame.host_ns + day_minus_host_ns_;
  const auto is_off = [&] { return std::abs(frame.device_ns + *day_minus_device_ns_ - arrived_ns) > kClockJump_ns; };
  if (!day_minus_device_ns_ || is_off()) day_minus_device_ns_ = arrived_ns - frame.device_ns;
  bag_.set_time(frame.device_ns + *day_minus_device_ns_, arrived_ns);
}

void Ros2RecordingWriter::add_depth(const RawFrame& frame) {
  const auto [width, height] = std::pair(frame.profile.width, frame.profile.height);
  if (calibration_.depth.intrinsics.width > 0) {
    bag_.add_camera(Ros2Topic::kDepthCamera, kRos2DepthFrame, calibration_.depth);
  }
  constexpr double kMillimetre_m = 0.001, kAlmost = 1e-9;
  if (std::abs(calibration_.depth_unit_m - kMillimetre_m) < kAlmost) {
    bag_.add_image(Ros2Topic::kDepth, kRos2DepthFrame, "16UC1", width, height, *frame.bytes);
  } else {
    bag_.add_image(Ros2Topic::kDepth, kRos2DepthFrame, "32FC1", width, height,
                   metres_of(*frame.bytes, calibration_.depth_unit_m));
  }
}

void Ros2RecordingWriter::add_colour(const RawFrame& frame) {
  if (calibration_.colour.intrinsics.width > 0) {
    bag_.add_camera(Ros2Topic::kColourCamera, kRos2ColourFrame, calibration_.colour);
  }
  if (frame.profile.format == PixelFormat::kMjpeg) {
    bag_.add_packed_colour(kRos2ColourFrame, *frame.bytes);
  } else {
    bag_.add_image(Ros2Topic::kColour, kRos2ColourFrame, encoding_of(frame.profile.format), frame.profile.width,
                   frame.profile.height, *frame.bytes);
  }
}

Result<void> Ros2RecordingWriter::flush() {
  frames_waiting_ = 0;
  return bag_.flush();
}

Result<void> Ros2RecordingWriter::finish() {
  frames_waiting_ = 0;
  return bag_.finish();
}

}  // namespace scanknit
