// Recordings of ScanNet, written here by the description of their format.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>

#include "acquire/mcap/byte_appender.h"
#include "acquire/raw/raw_recording.h"
#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test::sens {
namespace {

using Bytes = std::vector<std::byte>;
using Matrix = Eigen::Matrix<float, 4, 4, Eigen::RowMajor>;

constexpr std::uint32_t kColumns = 4, kRows = 3;

Bytes as_bytes(const std::vector<std::uint8_t>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

Matrix camera(float f) {
  Matrix k = Matrix::Identity();
  k(0, 0) = f;
  k(1, 1) = f + 1;
  k(0, 2) = 1.5f;
  k(1, 2) = 1;
  return k;
}

Matrix moved(float x) {
  Matrix pose = Matrix::Identity();
  pose(0, 3) = x;
  return pose;
}

/// A file of 4 x 3 pixels of depth and 8 x 6 of colour.
class SensWriter {
 public:
  Matrix T_colour = Matrix::Identity();
  std::int32_t colour_coding = 2, depth_coding = 1;

  void add(const Matrix& pose, std::uint64_t time_us, std::uint16_t first_depth) {
    ByteAppender frame(frames_);
    matrix(pose, frames_);
    frame.little_endian(time_us + 1);
    frame.little_endian(time_us);
    const Bytes colour = colour_bytes(static_cast<std::uint8_t>(first_depth % 200)), depth = depth_bytes(first_depth);
    frame.little_endian(std::uint64_t{colour.size()});
    frame.little_endian(std::uint64_t{depth.size()});
    frame.append(colour);
    frame.append(depth);
    ++count_;
  }

  [[nodiscard]] Bytes file() const {
    Bytes bytes;
    ByteAppender out(bytes);
    out.little_endian(std::uint32_t{4});
    const std::string_view name = "StructureSensor";
    out.little_endian(std::uint64_t{name.size()});
    out.append(std::as_bytes(std::span(name)));
    for (const Matrix& m : {camera(10), T_colour, camera(5), Matrix(Matrix::Identity())}) matrix(m, bytes);
    out.little_endian(colour_coding);
    out.little_endian(depth_coding);
    for (const std::uint32_t side : {2 * kColumns, 2 * kRows, kColumns, kRows}) out.little_endian(side);
    out.little_endian(2000.0f);
    out.little_endian(count_);
    out.append(frames_);
    out.little_endian(std::uint64_t{0});  // no inertial measurements
    return bytes;
  }

 private:
  static void matrix(const Matrix& matrix, Bytes& bytes) {
    for (int i = 0; i < 16; ++i) ByteAppender(bytes).little_endian(matrix(i / 4, i % 4));
  }
  [[nodiscard]] Bytes colour_bytes(std::uint8_t red) const {
    const ColourImage picture(2 * kColumns, 2 * kRows, Rgb8{red, 2, 3});
    if (colour_coding == 2) return as_bytes(encode_jpeg(picture, 100).value());
    if (colour_coding == 1) return as_bytes(encode_png(picture, PngEffort::kFast).value());
    std::vector<std::uint8_t> raw;
    for (const Rgb8& pixel : picture.pixels()) raw.insert(raw.end(), {pixel.r, pixel.g, pixel.b});
    return as_bytes(raw);
  }
  [[nodiscard]] Bytes depth_bytes(std::uint16_t first) const {
    Bytes raw;
    for (std::uint16_t i = 0; i < kColumns * kRows; ++i) {
      ByteAppender(raw).little_endian(static_cast<std::uint16_t>(i == 5 ? 0 : first + i));
    }
    if (depth_coding == 0) return raw;
    Bytes packed(compressBound(raw.size()));
    uLongf size = packed.size();
    EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
                       raw.size()),
              Z_OK);
    packed.resize(size);
    return packed;
  }

  Bytes frames_;
  std::uint64_t count_ = 0;
};

SensWriter short_walk() {
  SensWriter writer;
  writer.add(moved(0), 100'000, 1000);
  writer.add(moved(0.5f), 133'000, 1100);
  writer.add(moved(1), 166'000, 1200);
  return writer;
}

Played played(const SensWriter& writer) {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.sens", writer.file());
  return play(folder / "scene.sens");
}

TEST(Sens, GivesFramesWithCamerasPosesAndTimes) {
  const Played p = played(short_walk());
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 3u);
  const Frame& frame = p.frames[1];
  EXPECT_EQ(frame.timestamp_ns, 133'000'000);
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{4, 3, 5, 6, 1.5, 1}));
  EXPECT_EQ(frame.depth_m.at(0, 0), 0.55f) << "2000 units a metre";
  EXPECT_EQ(frame.depth_m.at(1, 1), 0) << "a hole";
  EXPECT_EQ(frame.depth_m.at(3, 2), 1111 / 2000.0f);
  ASSERT_TRUE(frame.T_world_camera);
  EXPECT_EQ(frame.T_world_camera->translation(), Eigen::Vector3d(0.5, 0, 0));
  ASSERT_TRUE(frame.colour);
  EXPECT_EQ(frame.colour->intrinsics, (CameraIntrinsics{8, 6, 10, 11, 1.5, 1}));
  EXPECT_NEAR(frame.colour->image.at(7, 5).r, 100, 3);
}

TEST(Sens, IsReadInAllOfItsCodings) {
  for (const std::int32_t colour : {0, 1, 2}) {
    for (const std::int32_t depth : {0, 1}) {
      SensWriter writer;
      writer.colour_coding = colour;
      writer.depth_coding = depth;
      writer.add(moved(0), 100, 1000);
      const Played p = played(writer);
      ASSERT_EQ(p.frames.size(), 1u) << colour << depth;
      EXPECT_EQ(p.frames[0].depth_m.at(3, 2), 1011 / 2000.0f);
      EXPECT_EQ(p.frames[0].colour.value().image.width(), 8);
    }
  }
}

TEST(Sens, KeepsThePicturesOfAFrameTogetherWithoutAClock) {
  SensWriter writer;
  for (std::uint16_t i = 0; i < 3; ++i) writer.add(moved(0), 0, static_cast<std::uint16_t>(1000 + 75 * i));
  const Played p = played(writer);
  ASSERT_EQ(p.frames.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    constexpr std::array<int, 3> kReds = {0, 75, 150};
    EXPECT_NEAR(p.frames[i].colour.value().image.at(0, 0).r, kReds[i], 3) << i;
  }
}

TEST(Sens, LeavesOutFramesWhosePoseIsNotKnown) {
  SensWriter writer;
  writer.add(moved(0), 100, 1000);
  writer.add(Matrix::Constant(-std::numeric_limits<float>::infinity()), 200, 1000);  // as ScanNet has it
  const Played p = played(writer);
  EXPECT_EQ(p.frames.size(), 1u);
  EXPECT_EQ(p.dropped.size(), 1u);
}

TEST(Sens, WithoutAlignedColourSaysSo) {
  SensWriter writer;
  writer.T_colour = moved(0.02f);
  writer.add(moved(0), 100, 1000);
  const Bytes file = writer.file();
  const auto recording = index_sens(std::make_unique<MemoryAccess>(file), "a.sens", {});
  ASSERT_TRUE(recording);
  EXPECT_TRUE(contains(recording->warnings.at(0), "not aligned"));
  EXPECT_TRUE(recording->entries.at(0).colour.empty());
}

TEST(Sens, RefusesDepthOfOtherCodings) {
  SensWriter writer = short_walk();
  writer.depth_coding = 2;
  const Bytes file = writer.file();
  const auto recording = index_sens(std::make_unique<MemoryAccess>(file), "a.sens", {});
  ASSERT_FALSE(recording);
  EXPECT_TRUE(contains(recording.error().message, "packed in a way"));
}

/// How many frames of a file in memory can be decoded.
std::size_t frames_in(const Bytes& file) {
  AcquireConfig config;
  config.limits.max_image_pixels = 1 << 16;
  config.limits.max_image_bytes = 1 << 20;
  const auto recording = index_sens(std::make_unique<MemoryAccess>(file), "a.sens", config);
  if (!recording) return 0;
  const DecodeSettings settings{.limits = config.limits};
  std::size_t whole = 0;
  for (const FrameEntry& entry : recording->entries) {
    whole += std::holds_alternative<DecodedFrame>(recording->decode(entry, settings)) ? 1u : 0u;
  }
  return whole;
}

TEST(Sens, CutAtAnyByteGivesWhatIsWhole) {
  const Bytes whole = short_walk().file();
  std::size_t before = 0;
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const std::size_t frames = frames_in({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    ASSERT_GE(frames, before) << size;
    before = frames;
  }
  EXPECT_EQ(before, 3u);
}

TEST(Sens, SurvivesAnyWrongByte) {
  const Bytes whole = short_walk().file();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes damaged = whole;
      damaged[i] ^= static_cast<std::byte>(change);
      EXPECT_LE(frames_in(damaged), 3u);
    }
  }
}

}  // namespace
}  // namespace scanknit::test::sens
