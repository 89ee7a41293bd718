// Recordings of Azure Kinect, written here by the description of their format, and by MKVToolNix.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "acquire/mkv/azure_calibration.h"
#include "acquire/mkv/ebml_reader.h"
#include "acquire/raw/raw_recording.h"
#include "core/picture/jpeg_codec.h"
#include "mkv_writer.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test::azure_mkv {
namespace {

using Bytes = MkvWriter::Bytes;
using Json = nlohmann::json;

constexpr int kDepthWidth = 6, kDepthHeight = 4, kColourWidth = 16, kColourHeight = 12;
constexpr std::uint64_t kDepth = 2, kColour = 1, kInfrared = 3, kMotion = 4;
constexpr Rgb8 kOrange{200, 100, 50};

Json camera(const char* location, int width, int height, std::vector<double> parameters) {
  const bool is_depth = std::string(location) == "D0";
  return {{"Location", std::string("CALIBRATION_CameraLocation") + location},
          {"SensorWidth", width},
          {"SensorHeight", height},
          {"Intrinsics",
           {{"ModelParameters", std::move(parameters)}, {"ModelType", "CALIBRATION_LensDistortionModelBrownConrady"}}},
          {"Rt",
           {{"Rotation", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
            {"Translation", is_depth ? std::vector<double>{0, 0, 0} : std::vector<double>{-0.032, -0.002, 0.004}}}}};
}

/// Cameras without distortion, of sensors as large as their pictures.
Json straight_cameras() {
  Json json;
  auto& cameras = json["CalibrationInformation"]["Cameras"];
  cameras.push_back(camera("D0", kDepthWidth, kDepthHeight, {0.5, 0.5, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  cameras.push_back(camera("PV0", kColourWidth, kColourHeight, {0.5, 0.5, 1, 1.5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  return json;
}

Bytes big_endian_depth(std::uint16_t first) {
  Bytes bytes;
  for (int i = 0; i < kDepthWidth * kDepthHeight; ++i) {
    MkvWriter::put(bytes, i == 7 ? 0u : first + static_cast<unsigned>(i), 2);
  }
  return bytes;
}

/// One colour in each of the codings. Y, U and V of kOrange, by BT.601.
Bytes colour_picture(const std::string& fourcc) {
  constexpr std::byte kY{123}, kU{91}, kV{175};
  constexpr std::size_t kPixels = std::size_t{kColourWidth} * kColourHeight;
  Bytes bytes;
  if (fourcc == "MJPG") {
    const auto jpeg = encode_jpeg(ColourImage(kColourWidth, kColourHeight, kOrange), 100).value();
    const auto as_bytes = std::as_bytes(std::span(jpeg));
    return {as_bytes.begin(), as_bytes.end()};
  }
  for (std::size_t i = 0; i < kPixels; ++i) {
    if (fourcc == "NV12") bytes.push_back(kY);
    if (fourcc == "YUY2") bytes.insert(bytes.end(), {kY, i % 2 == 0 ? kU : kV});
    if (fourcc == "BGRA") bytes.insert(bytes.end(), {std::byte{50}, std::byte{100}, std::byte{200}, std::byte{255}});
  }
  for (std::size_t i = 0; i < kPixels / 4 && fourcc == "NV12"; ++i) bytes.insert(bytes.end(), {kU, kV});
  return bytes;
}

MkvWriter empty_writer(const std::string& fourcc = "MJPG") {
  MkvWriter writer;
  writer.tracks = {{kColour, 101, "COLOR", fourcc, kColourWidth, kColourHeight},
                   {kDepth, 102, "DEPTH", "b16g", kDepthWidth, kDepthHeight},
                   {kInfrared, 103, "IR", "b16g", kDepthWidth, kDepthHeight},
                   {kMotion, 104, "IMU", "", 0, 0}};
  writer.tags = {{"K4A_DEPTH_TRACK", "102"}, {"K4A_COLOR_TRACK", "101"}, {"K4A_CALIBRATION_FILE", "calibration.json"}};
  writer.attached["calibration.json"] = straight_cameras().dump();
  return writer;
}

/// Three frames in two clusters, 33 ms apart; infrared holds other numbers.
MkvWriter filled(MkvWriter writer) {
  const Bytes colour = colour_picture(writer.tracks[0].fourcc);
  for (std::uint16_t i = 0; i < 3; ++i) {
    if (i != 1) writer.begin_cluster(1'000'000 + std::uint64_t{i} * 33'000);
    const auto later = static_cast<std::int16_t>(i == 1 ? 31'000 : 0);
    writer.add(kColour, later, colour);
    writer.add(kDepth, later, big_endian_depth(static_cast<std::uint16_t>(1000 + 100 * i)));
    writer.add(kInfrared, later, big_endian_depth(5000));
    writer.add(kMotion, later, Bytes(24));
  }
  return writer;
}

MkvWriter short_scan() {
  return filled(empty_writer());
}

Result<Recording> indexed(const Bytes& file, const AcquireConfig& config = {}) {
  return index_azure_mkv(std::make_unique<MemoryAccess>(file), "a.mkv", config);
}

std::string error_of(const MkvWriter& writer) {
  const Bytes file = writer.file();
  const auto recording = indexed(file);
  return recording ? "" : recording.error().text();
}

Played played(const MkvWriter& writer) {
  const TemporaryFolder folder;
  write_bytes(folder / "scan.mkv", writer.file());
  return play(folder / "scan.mkv");
}

TEST(AzureMkv, GivesFramesWithCamerasAndTimes) {
  const TemporaryFolder folder;
  write_bytes(folder / "scan.mkv", short_scan().file());
  auto source = open_recording(folder.path(), {});  // a folder with one recording
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "azure-mkv");
  EXPECT_TRUE((*source)->info().warnings.empty());
  const Played p = play(**source);
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 3u);
  EXPECT_EQ(p.frames[0].timestamp_ns, 1'000'000'000);
  EXPECT_EQ(p.frames[1].timestamp_ns, 1'031'000'000);
  EXPECT_EQ(p.frames[2].timestamp_ns, 1'066'000'000);
  const Frame& frame = p.frames[1];
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{kDepthWidth, kDepthHeight, 6, 8, 2.5, 1.5}));
  EXPECT_EQ(frame.depth_m.at(0, 0), 1.1f) << "millimetres, big endian";
  EXPECT_EQ(frame.depth_m.at(1, 1), 0) << "a hole";
  EXPECT_EQ(frame.depth_m.at(5, 3), 1.123f);
  ASSERT_TRUE(frame.colour);
  EXPECT_EQ(frame.colour->intrinsics, (CameraIntrinsics{kColourWidth, kColourHeight, 16, 18, 7.5, 5.5}));
  EXPECT_TRUE(frame.colour->T_colour_depth.translation().isApprox(Eigen::Vector3d(-0.032, -0.002, 0.004)));
  EXPECT_NE(frame.colour->encoded, nullptr) << "a JPEG that is not bent stays as it is";
}

TEST(AzureMkv, ReadsColourInAllOfItsCodings) {
  for (const char* fourcc : {"MJPG", "NV12", "YUY2", "BGRA"}) {
    const Played p = played(filled(empty_writer(fourcc)));
    ASSERT_EQ(p.frames.size(), 3u) << fourcc;
    for (const Frame& frame : p.frames) {
      ASSERT_TRUE(frame.colour) << fourcc;
      for (const Rgb8& pixel : frame.colour->image.pixels()) {
        constexpr int kRounding = 3;  // of YUV in bytes
        EXPECT_NEAR(pixel.r, kOrange.r, kRounding) << fourcc;
        EXPECT_NEAR(pixel.g, kOrange.g, kRounding) << fourcc;
        EXPECT_NEAR(pixel.b, kOrange.b, kRounding) << fourcc;
      }
    }
  }
}

TEST(AzureMkv, TakesTheChromaOfNv12FromItsTwoByTwoPixels) {
  MkvWriter writer = empty_writer("NV12");
  Bytes picture = colour_picture("NV12");
  const std::size_t chroma = std::size_t{kColourWidth} * kColourHeight;
  picture[chroma + kColourWidth + 4] = std::byte{128};  // U and V of rows 2, 3 and columns 4, 5
  picture[chroma + kColourWidth + 5] = std::byte{128};
  writer.begin_cluster(0);
  writer.add(kDepth, 0, big_endian_depth(1000));
  writer.add(kColour, 0, picture);
  const Played p = played(writer);
  ASSERT_EQ(p.frames.size(), 1u);
  const ColourImage& image = p.frames[0].colour.value().image;
  for (int y = 0; y < kColourHeight; ++y) {
    for (int x = 0; x < kColourWidth; ++x) {
      const Rgb8 pixel = image.at(x, y);
      EXPECT_EQ(pixel.r == pixel.b, y / 2 == 1 && x / 2 == 2) << x << ' ' << y;
    }
  }
}

TEST(AzureMkv, IsTheSameInEveryWayOfWritingClusters) {
  const Played expected = played(short_scan());
  for (const bool has_open_sizes : {false, true}) {
    for (const bool has_simple_blocks : {false, true}) {
      MkvWriter writer = empty_writer();
      writer.has_open_sizes = has_open_sizes;
      writer.has_simple_blocks = has_simple_blocks;
      const Played p = played(filled(writer));
      ASSERT_EQ(p.frames.size(), expected.frames.size()) << has_open_sizes << has_simple_blocks;
      for (std::size_t i = 0; i < p.frames.size(); ++i) {
        EXPECT_EQ(p.frames[i].depth_m, expected.frames[i].depth_m);
        EXPECT_EQ(p.frames[i].timestamp_ns, expected.frames[i].timestamp_ns);
      }
    }
  }
}

TEST(AzureMkv, PairsColourByTime) {
  MkvWriter writer = empty_writer("BGRA");
  writer.begin_cluster(0);
  writer.add(kDepth, 0, big_endian_depth(1000));       // its colour is lost
  writer.add(kDepth, 32'000, big_endian_depth(1100));  // its colour comes with the next cluster
  writer.begin_cluster(32'500);
  writer.add(kColour, 0, colour_picture("BGRA"));
  const Played p = played(writer);
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_FALSE(p.frames[0].colour);
  EXPECT_TRUE(p.frames[1].colour);
}

TEST(AzureMkv, StraightensBothLenses) {
  Json cameras = straight_cameras();
  for (Json& camera : cameras["CalibrationInformation"]["Cameras"]) {
    auto& parameters = camera["Intrinsics"]["ModelParameters"];
    parameters[4] = 2.0;   // k1
    parameters[7] = 0.5;   // k4
    parameters[12] = 0.1;  // p2
    parameters[13] = 0.2;  // p1
  }
  MkvWriter writer = empty_writer("BGRA");
  writer.attached["calibration.json"] = cameras.dump();
  const Played bent = played(filled(writer)), straight = played(filled(empty_writer("BGRA")));
  ASSERT_EQ(bent.frames.size(), 3u);
  const RationalDistortion lens{2.0, 0, 0.2, 0.1, 0, 0.5, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const Frame& frame = straight.frames[i];
    EXPECT_EQ(bent.frames[i].depth_m, undistort(frame.depth_m, frame.intrinsics, lens));
    EXPECT_NE(bent.frames[i].depth_m, frame.depth_m);
    EXPECT_EQ(bent.frames[i].colour.value().image, undistort(frame.colour->image, frame.colour->intrinsics, lens));
  }
}

TEST(AzureMkv, IsReadWithACameraThatIsStated) {
  MkvWriter writer = short_scan();
  writer.attached.clear();
  const TemporaryFolder folder;
  write_bytes(folder / "scan.mkv", writer.file());
  const std::string error = open_error(folder / "scan.mkv");
  EXPECT_TRUE(contains(error, "no calibration.json is attached")) << error;
  EXPECT_TRUE(contains(error, "acquire.intrinsics=[")) << error;
  AcquireConfig config;
  config.intrinsics = CameraModel{{0, 0, 7, 7, 3, 2}, {}};
  const auto source = open_recording(folder / "scan.mkv", config);
  ASSERT_TRUE(source) << source.error().text();
  ASSERT_EQ((*source)->info().warnings.size(), 1u) << "without the cameras' places colour cannot be laid on depth";
  EXPECT_TRUE(contains((*source)->info().warnings[0], "colour is not read"));
  const Played p = play(**source);
  ASSERT_EQ(p.frames.size(), 3u);
  EXPECT_EQ(p.frames[0].intrinsics.fx, 7);
  EXPECT_FALSE(p.frames[0].colour);
}

TEST(AzureMkv, WithoutDepthSaysWhichTracksThereAre) {
  MkvWriter writer = short_scan();
  writer.tags.erase("K4A_DEPTH_TRACK");
  writer.tracks[1].name = "other";
  const std::string error = error_of(writer);
  EXPECT_TRUE(contains(error, "COLOR (MJPG), other (b16g), IR (b16g), IMU (S_K4A/IMU)")) << error;
}

TEST(AzureMkv, FindsItsTracksByNameWithoutTags) {
  MkvWriter writer = short_scan();
  writer.tags.clear();
  const Played p = played(writer);
  ASSERT_EQ(p.frames.size(), 3u);
  EXPECT_TRUE(p.frames[0].colour);
}

TEST(AzureMkv, NamesACodingThatItDoesNotRead) {
  MkvWriter depth = short_scan();
  depth.tracks[1].fourcc = "H264";
  EXPECT_TRUE(contains(error_of(depth), "coded as 'H264'"));
  MkvWriter packed = short_scan();
  packed.more_of_tracks = MkvWriter::element(0x6D80, MkvWriter::element(0x6240, {}));
  EXPECT_TRUE(contains(error_of(packed), "packed by Matroska"));
  MkvWriter colour = filled(empty_writer("MJPG"));
  colour.tracks[0].fourcc = "HEVC";
  const Bytes file = colour.file();
  const auto recording = indexed(file);
  ASSERT_TRUE(recording);
  EXPECT_TRUE(contains(recording->warnings.at(0), "'HEVC'"));
  EXPECT_TRUE(recording->entries.at(0).colour.empty());
}

TEST(AzureMkv, SaysWhatItDoesNotReadOfALens) {
  const auto error_with = [](const auto& change) {
    Json json = straight_cameras();
    change(json["CalibrationInformation"]["Cameras"][0]);
    MkvWriter writer = short_scan();
    writer.attached["calibration.json"] = json.dump();
    return error_of(writer);
  };
  EXPECT_TRUE(contains(error_with([](Json& c) { c["Intrinsics"]["ModelType"] = "Rational6KT"; }), "Rational6KT"));
  EXPECT_TRUE(contains(error_with([](Json& c) { c["Intrinsics"]["ModelParameters"] = {1, 2}; }), "14 numbers"));
  EXPECT_TRUE(contains(error_with([](Json& c) { c["Location"] = "elsewhere"; }), "LocationD0"));
  EXPECT_TRUE(contains(error_with([](Json& c) { c["Rt"]["Rotation"][0] = 5; }), "Rt"));
  EXPECT_TRUE(contains(error_with([](Json& c) { c["SensorWidth"] = 7; }), "no mode of its sensor"));
}

TEST(AzureMkv, LeavesOutBlocksOfSeveralPicturesWithAWarning) {
  MkvWriter writer = empty_writer();
  writer.block_flags = 0x02;
  const Bytes file = filled(writer).file();
  const auto recording = indexed(file);
  ASSERT_TRUE(recording);
  EXPECT_TRUE(recording->entries.empty());
  EXPECT_TRUE(contains(recording->warnings.at(0), "lacing"));
}

TEST(AzureMkv, IsNotTakenForOneWithoutItsHead) {
  MkvWriter writer = short_scan();
  writer.doc_type = "webm";
  const Bytes webm = writer.file();
  EXPECT_FALSE(fits_azure_mkv(MemoryAccess(webm)));
  const Bytes file = short_scan().file();
  EXPECT_TRUE(fits_azure_mkv(MemoryAccess(file)));
  EXPECT_FALSE(fits_azure_mkv(MemoryAccess(std::span(file).subspan(1))));
}

// The raw calibration of one device, and what its SDK gives for 640 x 576 and 1080p, as published by a user.
TEST(AzureCalibration, GivesTheCamerasOfModesAsTheSdkDoes) {
  AzureCamera depth;
  depth.cx = 0.5122697949409485;
  depth.cy = 0.49451231956481934;
  depth.fx = 0.4921168386936188;
  depth.fy = 0.4921667277812958;
  depth.sensor_width = 1024;
  depth.sensor_height = 1024;
  constexpr double kPrinted = 1e-4;
  const auto narrow = azure_depth_camera(depth, 640, 576);
  ASSERT_TRUE(narrow);
  EXPECT_NEAR(narrow->cx, 332.064270, kPrinted);
  EXPECT_NEAR(narrow->cy, 325.880615, kPrinted);
  EXPECT_NEAR(narrow->fx, 503.927643, kPrinted);
  EXPECT_NEAR(narrow->fy, 503.978729, kPrinted);
  const auto binned = azure_depth_camera(depth, 320, 288);
  EXPECT_NEAR(binned.value().cx + 0.5, (narrow->cx + 0.5) / 2, kPrinted);
  EXPECT_NEAR(binned.value().cy + 0.5, (narrow->cy + 0.5) / 2, kPrinted);
  const auto wide = azure_depth_camera(depth, 1024, 1024);
  EXPECT_NEAR(wide.value().cx, narrow->cx + 192, kPrinted);
  EXPECT_NEAR(wide.value().cy, narrow->cy + 180, kPrinted);
  EXPECT_FALSE(azure_depth_camera(depth, 640, 480));

  AzureCamera colour;
  colour.cx = 0.4967627227306366;
  colour.cy = 0.5108628273010254;
  colour.fx = 0.470907062292099;
  colour.fy = 0.6274453997612;
  colour.sensor_width = 4096;
  colour.sensor_height = 3072;
  const CameraIntrinsics full_hd = azure_colour_camera(colour, 1920, 1080);
  EXPECT_NEAR(full_hd.cx, 953.284424, kPrinted);
  EXPECT_NEAR(full_hd.cy, 555.142456, kPrinted);
  EXPECT_NEAR(full_hd.fx, 904.141541, kPrinted);
  EXPECT_NEAR(full_hd.fy, 903.521362, kPrinted);
  const CameraIntrinsics whole = azure_colour_camera(colour, 2048, 1536);
  EXPECT_NEAR(whole.cy, colour.cy * 1536 - 0.5, kPrinted);
}

TEST(EbmlNumber, IsReadInAllLengths) {
  for (std::size_t length = 1; length <= 8; ++length) {
    Bytes bytes(length);
    bytes[0] = static_cast<std::byte>(0x80 >> (length - 1));
    bytes[length - 1] |= std::byte{1};
    const auto number = read_ebml_number(bytes);
    ASSERT_TRUE(number);
    EXPECT_EQ(number->value, 1u);
    EXPECT_EQ(number->length, length);
    EXPECT_FALSE(number->is_unknown);
    EXPECT_FALSE(read_ebml_number(std::span(bytes).first(length - 1)));
  }
  EXPECT_TRUE(read_ebml_number(Bytes{std::byte{0xFF}}).value().is_unknown);
  EXPECT_FALSE(read_ebml_number(Bytes{std::byte{0}, std::byte{0xFF}}));
}

/// How many frames of a file in memory can be decoded.
std::size_t frames_in(const Bytes& file) {
  AcquireConfig config;
  config.limits.max_image_pixels = 1 << 12;
  config.limits.max_image_bytes = 1 << 16;
  config.limits.max_frames = 1000;
  const auto recording = indexed(file, config);
  if (!recording) return 0;
  const DecodeSettings settings{.limits = config.limits};
  std::size_t whole = 0;
  for (const FrameEntry& entry : recording->entries) {
    whole += std::holds_alternative<DecodedFrame>(recording->decode(entry, settings)) ? 1u : 0u;
  }
  return whole;
}

TEST(AzureMkv, CutAtAnyByteGivesWhatIsWhole) {
  for (const bool has_open_sizes : {false, true}) {
    MkvWriter writer = empty_writer();
    writer.has_open_sizes = has_open_sizes;
    const Bytes whole = filled(writer).file();
    std::size_t before = 0;
    for (std::size_t size = 0; size <= whole.size(); ++size) {
      const std::size_t frames = frames_in({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
      ASSERT_GE(frames, before) << size;
      before = frames;
    }
    EXPECT_EQ(before, 3u);
  }
}

TEST(AzureMkv, SaysThatItIsTorn) {
  Bytes file = short_scan().file();
  file.resize(file.size() - 100);
  const auto recording = indexed(file);
  ASSERT_TRUE(recording);
  EXPECT_GE(recording->entries.size(), 2u);
  EXPECT_TRUE(contains(recording->warnings.at(0), "torn"));
}

TEST(AzureMkv, SurvivesAnyWrongByte) {
  const Bytes whole = short_scan().file();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes damaged = whole;
      damaged[i] ^= static_cast<std::byte>(change);
      EXPECT_LE(frames_in(damaged), 6u) << i;
    }
  }
}

/// Counts the bytes that are read of a file that is not there: a recording, then holes.
class CountedAccess final : public RandomAccess {
 public:
  CountedAccess(Bytes bytes, std::uint64_t& count) : bytes_(std::move(bytes)), count_(count) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] bool read(std::uint64_t offset, std::span<std::byte> to) const override {
    count_ += to.size();
    return MemoryAccess(bytes_).read(offset, to);
  }

 private:
  Bytes bytes_;
  std::uint64_t& count_;
};

TEST(AzureMkv, ReadsNoPictureUntilItIsAskedFor) {
  MkvWriter writer = empty_writer("BGRA");
  constexpr std::size_t kFrames = 500, kPictureBytes = 10'000;
  for (std::size_t i = 0; i < kFrames; ++i) {
    writer.begin_cluster(i * 33'333);
    writer.add(kDepth, 0, Bytes(kPictureBytes));
  }
  std::uint64_t count = 0;
  const auto recording = index_azure_mkv(std::make_unique<CountedAccess>(writer.file(), count), "a.mkv", {});
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording->entries.size(), kFrames);
  EXPECT_LT(count, kFrames * 100 + 10'000);
}

void expect_same(const Played& played, const Played& expected, std::int64_t clock_ns) {
  for (const FrameDropped& drop : played.dropped) ADD_FAILURE() << drop.error.text();
  ASSERT_EQ(played.frames.size(), expected.frames.size());
  for (std::size_t i = 0; i < played.frames.size(); ++i) {
    const Frame& frame = played.frames[i];
    const Frame& other = expected.frames[i];
    EXPECT_EQ(frame.depth_m, other.depth_m) << i;
    EXPECT_EQ(frame.intrinsics, other.intrinsics) << i;
    const auto since_first = [i](const Played& p) { return p.frames[i].timestamp_ns - p.frames[0].timestamp_ns; };
    EXPECT_LE(std::abs(since_first(played) - since_first(expected)), clock_ns) << i;
    EXPECT_EQ(frame.colour.value().image, other.colour.value().image) << i;
    EXPECT_EQ(frame.colour->intrinsics, other.colour->intrinsics) << i;
    EXPECT_TRUE(frame.colour->T_colour_depth.isApprox(other.colour->T_colour_depth)) << i;
  }
}

// MKVToolNix writes the file anew: its own clusters, tags and attachments at other places, its own clock.
TEST(AzureMkv, IsTheSameWhenMkvmergeWritesIt) {
  for (const char* fourcc : {"MJPG", "NV12", "YUY2", "BGRA"}) {
    const TemporaryFolder folder;
    write_bytes(folder / "scan.mkv", filled(empty_writer(fourcc)).file());
    const Played expected = play(folder / "scan.mkv");
    for (const char* options : {"--timestamp-scale 1000", "--timestamp-scale 1000000", "--engage no_simpleblocks"}) {
      const std::string command = std::string("mkvmerge -q ") + options + " -o '" + (folder / "again.mkv").string() +
                                  "' '" + (folder / "scan.mkv").string() + "' > '" + (folder / "said").string() +
                                  "' 2>&1";
      const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): one thread
      constexpr int kNoSuchCommand = 127, kWithWarnings = 1;
      if (WEXITSTATUS(status) == kNoSuchCommand) {
        GTEST_SKIP() << "SKIPPED: mkvmerge is not installed (Debian package mkvtoolnix)";
      }
      const Bytes said = bytes_of(folder / "said");
      ASSERT_LE(WEXITSTATUS(status), kWithWarnings)
          << std::string_view(reinterpret_cast<const char*>(said.data()), said.size());
      expect_same(play(folder / "again.mkv"), expected, 1'000'000);
    }
  }
}

// A real recording, laid out so.
TEST(AzureMkv, HoldsARealRecordingAsItWas) {
  const auto real = data_folder() / "rgbd_box_f200";
  if (!std::filesystem::exists(real)) GTEST_SKIP() << "SKIPPED: no rgbd_box_f200 to read";
  AcquireConfig config;
  config.to = 9;
  const Played expected = play(real, config);
  ASSERT_GE(expected.frames.size(), 5u);
  const CameraIntrinsics k = expected.frames[0].intrinsics;
  const auto width = static_cast<std::uint64_t>(k.width), height = static_cast<std::uint64_t>(k.height);
  MkvWriter writer = empty_writer("BGRA");
  for (MkvWriter::Track& track : writer.tracks) {
    if (track.width > 0) track.width = width, track.height = height;
  }
  const std::vector<double> parameters{
      (k.cx + 0.5) / k.width, (k.cy + 0.5) / k.height, k.fx / k.width, k.fy / k.height, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  Json cameras;
  for (const char* location : {"D0", "PV0"}) {
    cameras["CalibrationInformation"]["Cameras"].push_back(camera(location, k.width, k.height, parameters));
  }
  writer.attached["calibration.json"] = cameras.dump();
  for (std::size_t i = 0; i < expected.frames.size(); ++i) {
    const Frame& frame = expected.frames[i];
    writer.begin_cluster(i * 33'333);
    Bytes depth, colour;
    for (const float z : frame.depth_m.pixels()) {
      MkvWriter::put(depth, static_cast<std::uint64_t>(std::lround(z * 1000)), 2);
    }
    for (const Rgb8& pixel : frame.colour.value().image.pixels()) {
      for (const std::uint8_t part : {pixel.b, pixel.g, pixel.r, std::uint8_t{255}}) colour.push_back(std::byte{part});
    }
    writer.add(kDepth, 0, depth);
    writer.add(kColour, 50, colour);
  }
  const Played p = played(writer);
  ASSERT_EQ(p.frames.size(), expected.frames.size());
  for (std::size_t i = 0; i < p.frames.size(); ++i) {
    EXPECT_EQ(p.frames[i].depth_m, expected.frames[i].depth_m) << i;
    EXPECT_EQ(p.frames[i].colour.value().image, expected.frames[i].colour->image) << i;
    EXPECT_NEAR(p.frames[i].intrinsics.fx, k.fx, 1e-9);
    EXPECT_NEAR(p.frames[i].intrinsics.cx, k.cx, 1e-9);
  }
}

}  // namespace
}  // namespace scanknit::test::azure_mkv
