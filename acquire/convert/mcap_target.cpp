// A recording of our own from any other.
#include <optional>
#include <utility>

#include "acquire/convert/recording_target.h"
#include "acquire/mcap/byte_appender.h"
#include "acquire/record/recording_writer.h"
#include "core/files/atomic_file.h"
#include "core/picture/jpeg_structure.h"

namespace scanknit {
namespace {

RawFrame raw_frame(const ConvertedFrame& converted, StreamKind kind, PixelFormat format, int width, int height,
                   std::shared_ptr<const std::vector<std::byte>> bytes) {
  RawFrame raw;
  raw.profile = {kind, format, width, height, 0};
  raw.sequence = converted.frame.sequence;
  raw.device_ns = converted.time_ns;
  raw.host_ns = converted.time_ns;
  raw.bytes = std::move(bytes);
  return raw;
}

RawFrame raw_depth(const ConvertedFrame& converted) {
  std::vector<std::byte> bytes;
  bytes.reserve(2 * converted.raw_depth.size());
  for (const std::uint16_t value : converted.raw_depth.pixels()) {
    bytes.push_back(static_cast<std::byte>(value & 0xFF));
    bytes.push_back(static_cast<std::byte>(value >> 8));
  }
  return raw_frame(converted, StreamKind::kDepth, PixelFormat::kZ16, converted.raw_depth.width(),
                   converted.raw_depth.height(), std::make_shared<const std::vector<std::byte>>(std::move(bytes)));
}

RawFrame raw_colour(const ConvertedFrame& converted) {
  const ColourFrame& colour = *converted.frame.colour;
  const int width = colour.image.width();
  const int height = colour.image.height();
  if (colour.encoded && looks_like_jpeg(*colour.encoded)) {
    return raw_frame(converted, StreamKind::kColour, PixelFormat::kMjpeg, width, height, colour.encoded);
  }
  std::vector<std::byte> bytes;
  bytes.reserve(3 * colour.image.size());
  for (const Rgb8& pixel : colour.image.pixels()) {
    bytes.push_back(std::byte{pixel.r});
    bytes.push_back(std::byte{pixel.g});
    bytes.push_back(std::byte{pixel.b});
  }
  return raw_frame(converted, StreamKind::kColour, PixelFormat::kRgb8, width, height,
                   std::make_shared<const std::vector<std::byte>>(std::move(bytes)));
}

class McapTarget final : public RecordingTarget {
 public:
  explicit McapTarget(AtomicFile file) : file_(std::move(file)) {}

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const Frame& frame = converted.frame;
    if (!writer_) {
      calibration_ = calibration_of(converted);
      writer_.emplace([this](std::span<const std::byte> bytes) { return file_.write(bytes); }, calibration_);
      if (auto begun = writer_->begin(); !begun) return begun;
    }
    if (frame.intrinsics != calibration_.depth.intrinsics) {
      warn("the camera's intrinsics change on the way; those of the first frame are kept");
    }
    const RawFrame depth = raw_depth(converted);
    if (auto written = writer_->write(depth); !written) return written;
    if (frame.T_world_camera) writer_->write_pose(depth, *frame.T_world_camera);
    return frame.colour ? writer_->write(raw_colour(converted)) : Result<void>{};
  }

  [[nodiscard]] Result<void> finish() override {
    if (auto finished = writer_->finish(); !finished) return finished;
    return file_.commit();
  }

 private:
  [[nodiscard]] static RawCalibration calibration_of(const ConvertedFrame& converted) {
    RawCalibration calibration;
    calibration.depth.intrinsics = converted.frame.intrinsics;
    if (const auto& colour = converted.frame.colour) {
      calibration.colour.intrinsics = colour->intrinsics;
      calibration.T_colour_depth = colour->T_colour_depth;
    }
    calibration.depth_unit_m = 1 / converted.units_per_metre;
    calibration.source = "converted";
    return calibration;
  }

  AtomicFile file_;
  RawCalibration calibration_;
  std::optional<RecordingWriter> writer_;
};

}  // namespace

OpenedTarget open_mcap_target(const std::filesystem::path& path) {
  if (auto writable = check_writable(path); !writable) return writable.error();
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<RecordingTarget>(std::make_unique<McapTarget>(*std::move(file)));
}

}  // namespace scanknit
