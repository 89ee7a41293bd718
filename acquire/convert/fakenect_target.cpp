// Dumps that libfreenect's player (fakenect) plays: INDEX.txt, d-HOST-DEVICE.pgm, r-HOST-DEVICE.ppm.
#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "acquire/convert/picture_files.h"
#include "acquire/convert/recording_target.h"
#include "acquire/mcap/byte_appender.h"
#include "core/files/atomic_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

// The player knows no other size: it copies this many pixels out of each file.
constexpr int kWidth = 640;
constexpr int kHeight = 480;

std::vector<std::byte> text_bytes(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

class FakenectTarget final : public RecordingTarget {
 public:
  explicit FakenectTarget(fs::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const Image<std::uint16_t>& raw = converted.raw_depth;
    if (raw.width() != kWidth || raw.height() != kHeight) {
      return Error{
          ErrorCode::kInput,
          fmt::format("depth is {} x {}; a fakenect dump has 640 x 480 and nothing else", raw.width(), raw.height()),
          folder_.string()};
    }
    if (converted.frame.T_world_camera) warn("the layout has no poses: they are left out");
    if (converted.number == 0) {
      const fs::path path = folder_ / "camera_intrinsic.json";
      auto done = write_camera_json(converted.frame.intrinsics, converted.units_per_metre, path);
      if (!done) return done;
    }
    // The Kinect's clock: 60 MHz in 32 bits, which wrap round. The player sleeps by the other one.
    const auto ticks = static_cast<std::uint32_t>(static_cast<std::uint64_t>(converted.time_ns) / 50 * 3);
    const std::string stamp = fmt::format("{:.6f}-{}", static_cast<double>(converted.time_ns) * 1e-9, ticks);
    if (auto done = write_depth(raw, "d-" + stamp + ".pgm"); !done) return done;
    if (!converted.frame.colour) return {};
    const ColourImage colour =
        is_registered(converted.frame) ? converted.frame.colour->image : resample_colour(converted.frame);
    if (colour.width() != kWidth || colour.height() != kHeight) {
      warn("colour of another size than 640 x 480 has no place in a fakenect dump and is left out");
      return {};
    }
    return write_colour(colour, "r-" + stamp + ".ppm");
  }

  // The pose of a dump is nobody's: the format has none.
  [[nodiscard]] Result<void> finish() override { return write_file_atomically(folder_ / "INDEX.txt", index_); }

 private:
  // Sixteen bits in the order of the machine that plays, against the definition of PGM: as the player reads them.
  [[nodiscard]] Result<void> write_depth(const Image<std::uint16_t>& raw, const std::string& name) {
    std::vector<std::byte> bytes = text_bytes(fmt::format("P5 {} {} 65535\n", kWidth, kHeight));
    ByteAppender writer(bytes);
    for (const std::uint16_t value : raw.pixels()) writer.little_endian(value);
    index_ += name + "\n";
    return write_bytes(bytes, folder_ / name);
  }

  [[nodiscard]] Result<void> write_colour(const ColourImage& colour, const std::string& name) {
    std::vector<std::byte> bytes = text_bytes(fmt::format("P6 {} {} 255\n", kWidth, kHeight));
    for (const Rgb8& pixel : colour.pixels()) {
      for (const std::uint8_t channel : {pixel.r, pixel.g, pixel.b}) bytes.push_back(std::byte{channel});
    }
    index_ += name + "\n";
    return write_bytes(bytes, folder_ / name);
  }

  fs::path folder_;
  std::string index_;
};

}  // namespace

OpenedTarget open_fakenect_target(const fs::path& folder) {
  return std::unique_ptr<RecordingTarget>(std::make_unique<FakenectTarget>(folder));
}

}  // namespace scanknit
