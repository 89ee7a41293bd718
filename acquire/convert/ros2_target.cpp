// A bag of ROS 2 in an MCAP file: depth, colour, their cameras and the camera's way, as the messages that a robot
// records.
#include <fmt/format.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "acquire/convert/recording_target.h"
#include "acquire/ros2/ros2_bag_writer.h"
#include "core/files/atomic_file.h"
#include "core/picture/png_codec.h"

namespace scanknit {
namespace {

constexpr double kMillimetres = 1000;  // units of 16UC1 (ROS REP 118)
constexpr std::size_t kChunkBytes = 8u << 20;

class Ros2Target final : public RecordingTarget {
 public:
  explicit Ros2Target(AtomicFile file) : file_(std::move(file)) {}

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const Frame& frame = converted.frame;
    constexpr std::int64_t kLatest_ns = std::int64_t{std::numeric_limits<std::int32_t>::max()} * 1'000'000'000;
    if (converted.time_ns < 0 || converted.time_ns > kLatest_ns) {
      return Error{ErrorCode::kInput,
                   fmt::format("frame {} has the time {} s, and a bag of ROS 2 holds times from 0 to 2147483647 s",
                               frame.sequence, static_cast<double>(converted.time_ns) * 1e-9)};
    }
    if (!writer_) {
      is_colour_packed_ = !frame.colour || frame.colour->encoded;
      writer_.emplace([this](std::span<const std::byte> bytes) { return file_.write(bytes); },
                      Ros2BagLayout{"/camera/depth/image_rect_raw", is_colour_packed_});
      if (auto begun = writer_->begin(); !begun) return begun;
    }
    writer_->set_time(converted.time_ns, converted.time_ns);
    if (frame.T_world_camera) {
      writer_->add_transform(Ros2Topic::kTf, kRos2World, kRos2DepthFrame, *frame.T_world_camera);
    }
    writer_->add_camera(Ros2Topic::kDepthCamera, kRos2DepthFrame, {frame.intrinsics});
    add_depth(converted);
    if (frame.colour) {
      if (auto added = add_colour(frame); !added) return added;
    }
    return writer_->waiting_bytes() < kChunkBytes ? Result<void>() : writer_->flush();
  }

  [[nodiscard]] Result<void> finish() override {
    if (auto finished = writer_->finish(); !finished) return finished;
    return file_.commit();
  }

 private:
  void add_depth(const ConvertedFrame& converted) {
    const DepthImage& depth_m = converted.frame.depth_m;
    std::vector<std::byte> pixels;
    ByteAppender appender(pixels);
    const bool is_millimetres = converted.units_per_metre == kMillimetres;
    if (is_millimetres) {
      for (const std::uint16_t depth : converted.raw_depth.pixels()) appender.little_endian(depth);
    } else {
      for (const float depth : depth_m.pixels()) {
        appender.little_endian(depth > 0 ? depth : std::numeric_limits<float>::quiet_NaN());
      }
    }
    writer_->add_image(Ros2Topic::kDepth, kRos2DepthFrame, is_millimetres ? "16UC1" : "32FC1", depth_m.width(),
                       depth_m.height(), pixels);
  }

  [[nodiscard]] Result<void> add_colour(const Frame& frame) {
    const ColourFrame& colour = *frame.colour;
    const char* frame_id = kRos2DepthFrame;
    if (!is_registered(frame)) {
      frame_id = kRos2ColourFrame;
      if (!T_colour_depth_) {
        T_colour_depth_ = colour.T_colour_depth;
        writer_->add_transform(Ros2Topic::kTfStatic, kRos2DepthFrame, kRos2ColourFrame,
                               colour.T_colour_depth.inverse());
      } else if (!T_colour_depth_->isApprox(colour.T_colour_depth)) {
        warn("the colour camera's pose beside depth changes on the way; that of the first frame is kept");
      }
    }
    writer_->add_camera(Ros2Topic::kColourCamera, frame_id, {colour.intrinsics});
    if (is_colour_packed_) return add_packed_colour(frame_id, colour);
    std::vector<std::byte> pixels;
    pixels.reserve(3 * colour.image.size());
    for (const Rgb8& pixel : colour.image.pixels()) {
      for (const std::uint8_t channel : {pixel.r, pixel.g, pixel.b}) pixels.push_back(std::byte{channel});
    }
    writer_->add_image(Ros2Topic::kColour, frame_id, "rgb8", colour.image.width(), colour.image.height(), pixels);
    return {};
  }

  /// The picture's file as it is; a picture that came from none, among others that did, as a PNG.
  [[nodiscard]] Result<void> add_packed_colour(const char* frame_id, const ColourFrame& colour) {
    std::vector<std::uint8_t> png;
    std::span<const std::byte> bytes;
    if (colour.encoded) {
      bytes = *colour.encoded;
    } else {
      auto encoded = encode_png(colour.image, PngEffort::kFast);
      if (!encoded) return encoded.error();
      png = *std::move(encoded);
      bytes = std::as_bytes(std::span(png));
    }
    writer_->add_packed_colour(frame_id, bytes);
    return {};
  }

  AtomicFile file_;
  std::optional<Ros2BagWriter> writer_;
  bool is_colour_packed_ = false;  // by the first frame
  std::optional<Pose> T_colour_depth_;
};

}  // namespace

OpenedTarget open_ros2_target(const std::filesystem::path& path) {
  if (auto writable = check_writable(path); !writable) return writable.error();
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<RecordingTarget>(std::make_unique<Ros2Target>(*std::move(file)));
}

}  // namespace scanknit
