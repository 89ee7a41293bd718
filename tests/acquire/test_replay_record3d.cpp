// Record3D's .r3d: archives written here, and one that Python's zipfile and LZFSE's reference encoder made.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "acquire/raw/raw_recording.h"
#include "core/picture/jpeg_codec.h"
#include "record3d_scene.h"
#include "test_replay_support.h"
#include "tests/support/text.h"
#include "zip_writer.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::byte>;
using Json = nlohmann::json;
using Reasons = std::vector<std::string>;

Bytes bytes_of_text(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

/// Two frames of 8 x 6 pixels of depth and 16 x 12 of colour.
class Record3d : public ::testing::Test {
 protected:
  void SetUp() override {
    json_ = {{"w", 16},
             {"h", 12},
             {"dw", kWidth},
             {"dh", kHeight},
             {"fps", 30},
             {"K", {14, 0, 0, 0, 15, 0, 7.5, 5.5, 1}},
             {"perFrameIntrinsicCoeffs", {{14, 15, 7.5, 5.5}, {16, 16, 7.5, 5.5}}},
             {"poses", {{0, 0, 0, 1, 1, 2, 3}, {0, 0, 0, 1, 4, 5, 6}}},
             {"frameTimestamps", {330973.25, 330973.3}}};
    depth_ = {DepthImage(kWidth, kHeight, 1.25F), DepthImage(kWidth, kHeight, 1.5F)};
    depth_[0].at(1, 0) = std::numeric_limits<float>::quiet_NaN();
    depth_[0].at(2, 0) = -1;
    depth_[0].at(3, 0) = std::numeric_limits<float>::infinity();
    trust_ = Bytes(kWidth * kHeight, std::byte{2});
    trust_[5] = std::byte{1};
  }
  [[nodiscard]] Bytes depth_bytes(std::size_t i) const {
    Bytes bytes;
    for (const float z : depth_[i].pixels()) ByteAppender(bytes).little_endian(z);
    return plain_lzfse(bytes);
  }
  void fill(ZipWriter& writer) const {
    writer.add("metadata", bytes_of_text(json_.dump()));
    for (std::size_t i = 0; i < depth_.size(); ++i) {
      const std::string name = "rgbd/" + std::to_string(i);
      const ColourImage colour(16, 12, Rgb8{200, 100, static_cast<std::uint8_t>(50 * i)});
      const auto jpeg = encode_jpeg(colour, 100).value();
      const auto jpeg_bytes = std::as_bytes(std::span(jpeg));
      writer.add(name + ".jpg", {jpeg_bytes.begin(), jpeg_bytes.end()});
      writer.add(name + ".depth", depth_bytes(i));
      if (has_trust_) writer.add(name + ".conf", plain_lzfse(trust_));
    }
  }
  [[nodiscard]] Bytes file() const {
    ZipWriter writer;
    fill(writer);
    return writer.whole();
  }
  [[nodiscard]] Played played(const Bytes& bytes, const AcquireConfig& config = {}) const {
    write_bytes(folder_ / "scan.r3d", bytes);
    return play(folder_ / "scan.r3d", config);
  }

  TemporaryFolder folder_;
  Json json_;
  std::vector<DepthImage> depth_;
  Bytes trust_;
  bool has_trust_ = true;
};

TEST_F(Record3d, IsReadWithItsCamerasPosesAndTimes) {
  const Played p = played(file());
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 2u);
  const Frame& frame = p.frames[0];
  EXPECT_EQ(frame.timestamp_ns, 330'973'250'000'000);
  EXPECT_EQ(frame.depth_m.at(0, 0), 1.25F);
  for (const int x : {1, 2, 3}) EXPECT_EQ(frame.depth_m.at(x, 0), 0) << "not a number, negative, infinite";
  EXPECT_EQ(frame.depth_m.at(5, 0), 0) << "of medium confidence";
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{8, 6, 7, 7.5, 3.5, 2.5}));
  EXPECT_EQ(p.frames[1].intrinsics.fx, 8) << "the second frame's own camera";
  EXPECT_EQ(frame.colour.value().intrinsics, (CameraIntrinsics{16, 12, 14, 15, 7.5, 5.5}));
  EXPECT_NEAR(frame.colour->image.at(0, 0).r, 200, 3);
  const Eigen::Vector3d p_world = *frame.T_world_camera * Eigen::Vector3d(0.25, 0.5, 2);
  EXPECT_TRUE(p_world.isApprox(Eigen::Vector3d(1.25, 1.5, 1))) << "down is -y, forward is -z";
}

TEST_F(Record3d, DescribesItselfAndIsFoundInItsFolder) {
  write_bytes(folder_ / "scan.r3d", file());
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "record3d");
  EXPECT_EQ((*source)->info().world_up, UpAxis::kY);
  EXPECT_TRUE((*source)->info().warnings.empty());
  EXPECT_FALSE((*source)->info().sensor) << "8 x 6 is no LiDAR's size";
}

TEST_F(Record3d, IsTakenForAPhonesLidarByTheSizeOfItsDepth) {
  json_.update({{"w", 720}, {"h", 960}});
  json_.erase("dw");  // as older versions have it
  json_.erase("dh");
  depth_ = {DepthImage(192, 256, 1.5F)};
  has_trust_ = false;
  write_bytes(folder_ / "scan.r3d", file());
  const auto source = open_recording(folder_ / "scan.r3d", {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sensor->model, SensorModel::kPhoneLidar);
  EXPECT_EQ(play(**source).frames.at(0).depth_m.width(), 192);
}

TEST_F(Record3d, TakesMediumConfidenceIfAskedTo) {
  AcquireConfig config;
  config.min_confidence = 1;
  EXPECT_EQ(played(file(), config).frames.at(0).depth_m.at(5, 0), 1.25F);
}

TEST_F(Record3d, IsTheSameInEveryKindOfArchive) {
  const Played expected = played(file());
  for (const bool is_deflated : {false, true}) {
    for (const bool is_64 : {false, true}) {
      ZipWriter writer;
      writer.is_deflated = is_deflated;
      writer.is_64 = is_64;
      fill(writer);
      for (const Bytes& bytes : {writer.whole(), writer.whole("PK\5\6 a comment"), writer.archive}) {
        const Played p = played(bytes);
        ASSERT_EQ(p.frames.size(), 2u) << is_deflated << is_64;
        for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(p.frames[i].depth_m, expected.frames[i].depth_m);
      }
    }
  }
}

TEST_F(Record3d, IsReadAsPythonAndTheReferenceEncoderWriteIt) {
  write_bytes(folder_ / "scan.r3d", bytes_of(fs::path(kSourceDir) / "tests/fuzz/corpus/record3d/python"));
  const Played p = play(folder_ / "scan.r3d");
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const Frame& frame = p.frames[static_cast<std::size_t>(i)];
    for (int y = 0; y < kSceneHeight; ++y) {
      for (int x = 0; x < kSceneWidth; ++x) {
        // The left half of the first frame is of low confidence.
        const bool is_trusted = i == 1 || x >= kSceneWidth / 2;
        EXPECT_EQ(frame.depth_m.at(x, y), is_trusted ? scene_depth_m(1000 + 500 * i, x, y) : 0);
      }
    }
    EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{48, 32, 40, 41, 23.5, 15.5}));
    EXPECT_EQ(frame.T_world_camera->translation(), Eigen::Vector3d(i, 0, 0));
    EXPECT_EQ(frame.colour.value().image.width(), 48);
  }
}

TEST_F(Record3d, LeavesOutFramesThatCannotBeUsed) {
  json_["perFrameIntrinsicCoeffs"][0] = {0, 0, 1};
  json_.erase("K");
  json_["poses"][1] = {0, 0, 0, 0, 1, 2, 3};
  EXPECT_EQ(played(file()).reasons(), (Reasons{"no_intrinsics", "bad_pose"}));
  SetUp();
  depth_[1] = DepthImage(kWidth, kHeight - 1, 1.0F);
  const Played p = played(file());
  EXPECT_EQ(p.reasons(), Reasons{"unreadable"});
  EXPECT_TRUE(contains(p.dropped[0].error.text(), "scan.r3d/rgbd/1.depth: has 160 bytes unpacked, expected 192"))
      << p.dropped[0].error.text();
}

TEST_F(Record3d, SaysWhatIsWrongWithAnArchive) {
  ZipWriter writer;
  writer.flags = 1;
  fill(writer);
  write_bytes(folder_ / "scan.r3d", writer.whole());
  EXPECT_TRUE(contains(open_error(folder_ / "scan.r3d"), "'metadata' is encrypted"));
  json_["dw"] = 1 << 20;
  json_["dh"] = 1 << 20;
  write_bytes(folder_ / "scan.r3d", file());
  EXPECT_TRUE(contains(open_error(folder_ / "scan.r3d"), "more pixels than the limit"));
  write_bytes(folder_ / "scan.r3d", bytes_of_text("PK\3\4"));
  EXPECT_TRUE(contains(open_error(folder_ / "scan.r3d"), "no recording of a known layout"));
}

/// How many frames of a file in memory can be decoded.
std::size_t record3d_frames_in(const Bytes& file) {
  AcquireConfig config;
  config.limits.max_image_pixels = 1 << 16;
  config.limits.max_image_bytes = 1 << 20;
  const MemoryAccess access(file);
  if (!fits_record3d(access)) return 0;
  const auto recording = index_record3d(std::make_unique<MemoryAccess>(file), "a.r3d", config);
  if (!recording) return 0;
  const DecodeSettings settings{.min_confidence = 2, .limits = config.limits};
  std::size_t whole = 0;
  for (const FrameEntry& entry : recording->entries) {
    whole += std::holds_alternative<DecodedFrame>(recording->decode(entry, settings)) ? 1u : 0u;
  }
  return whole;
}

TEST_F(Record3d, CutAtAnyByteGivesWhatIsWhole) {
  const Bytes whole = file();
  std::size_t before = 0;
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const std::size_t frames = record3d_frames_in({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    ASSERT_GE(frames, before) << size;
    before = frames;
  }
  EXPECT_EQ(before, 2u);
}

TEST_F(Record3d, SurvivesAnyWrongByte) {
  for (const bool is_64 : {false, true}) {
    ZipWriter writer;
    writer.is_64 = is_64;
    writer.is_deflated = true;
    fill(writer);
    const Bytes whole = writer.whole();
    ASSERT_EQ(record3d_frames_in(whole), 2u);
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (const int change : {0x01, 0x80, 0xFF}) {
        Bytes damaged = whole;
        damaged[i] ^= static_cast<std::byte>(change);
        EXPECT_LE(record3d_frames_in(damaged), 2u);
      }
    }
  }
}

TEST_F(Record3d, SurvivesAnyOtherValue) {
  const std::vector<Json> values = {nullptr, true, -1, 0, 1e300, "x", Json::array(), Json::object(), {{1, 2}}};
  const Json whole = json_;
  for (const auto& [key, unused] : whole.items()) {
    for (const Json& value : values) {
      json_ = whole;
      json_[key] = value;
      EXPECT_LE(record3d_frames_in(file()), 2u);
    }
  }
}

}  // namespace
}  // namespace scanknit::test
