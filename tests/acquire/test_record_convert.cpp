// Converting and mending recordings: what the target can hold arrives as it was.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acquire/convert/convert_recording.h"
#include "acquire/convert/picture_files.h"
#include "acquire/mcap/append_file.h"
#include "acquire/record/recording_writer.h"
#include "acquire/record/repair_recording.h"
#include "acquire/replay/picture_codec.h"
#include "core/files/byte_reader.h"
#include "raw_frames.h"
#include "test_replay_support.h"
#include "tests/support/places.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kFrames = 3;

struct Named {
  ConvertTarget target;
  const char* name;
};
std::ostream& operator<<(std::ostream& out, const Named& named) {
  return out << named.name;
}

AcquireConfig keep_all() {
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  return config;
}

ConvertSummary convert(const fs::path& input, ConvertTarget target, const fs::path& output) {
  auto source = open_recording(input, keep_all());
  EXPECT_TRUE(source) << source.error().text();
  if (!source) return {};
  auto summary = convert_recording(**source, target, output);
  EXPECT_TRUE(summary) << summary.error().text();
  return summary ? *summary : ConvertSummary{};
}

bool is_colour_resampled(const ConvertSummary& summary) {
  return std::any_of(summary.warnings.begin(), summary.warnings.end(),
                     [](const std::string& text) { return text.find("resampled") != std::string::npos; });
}

class ConvertedFiles : public ::testing::Test {
 protected:
  // Depth with every digit, JPEG colour, poses, times; raw units of 1/1000 m. 640 x 480 as fakenect wants it.
  void SetUp() override {
    const fs::path open3d = folder_ / "input";
    ASSERT_TRUE(write_camera_json({640, 480, 525.5, 524.5, 319.25, 239.75}, 1000, open3d / "camera_intrinsic.json"));
    std::string log, times;
    for (std::uint32_t i = 0; i < kFrames; ++i) {
      Image<std::uint16_t> raw(640, 480);
      const auto bytes = depth_frame(i, 640, 480).bytes;
      ByteReader values(*bytes);
      for (std::uint16_t& value : raw.pixels()) value = values.little_endian<std::uint16_t>().value();
      const std::string name = "00000" + std::to_string(i);
      ASSERT_TRUE(write_depth_png(raw, open3d / "depth" / (name + ".png")));
      ColourImage colour(640, 480);
      for (std::size_t k = 0; k < colour.size(); ++k) {
        colour.pixels()[k] = {static_cast<std::uint8_t>(k / 640), static_cast<std::uint8_t>(k % 640 / 3),
                              static_cast<std::uint8_t>(40 * i)};
      }
      ASSERT_TRUE(write_colour_jpeg(colour, open3d / "color" / (name + ".jpg")));
      Pose pose(Eigen::Translation3d(0.1 * i, 1.0 / 3, 0));
      pose.rotate(Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized()));
      append_log_pose(log, i, pose.matrix());
      times += "12." + std::to_string(100'000'001 + 33'333'333 * i) + "\n";
    }
    write_text(open3d / "trajectory.log", log);
    write_text(open3d / "timestamps.txt", times);
    input_ = open3d;
  }

  /// A frame whose colour has a camera of its own.
  [[nodiscard]] fs::path write_two_cameras() const {
    const fs::path path = folder_ / "two_cameras.mcap";
    auto file = AppendFile::create(path);
    EXPECT_TRUE(file);
    RecordingWriter writer([&](std::span<const std::byte> bytes) { return file->append(bytes); },
                           raw_calibration(640, 480));
    EXPECT_TRUE(writer.begin());
    EXPECT_TRUE(writer.write(depth_frame(0, 640, 480)));
    writer.write_pose(depth_frame(0, 640, 480), Pose::Identity());
    EXPECT_TRUE(writer.write(colour_frame(0)));
    EXPECT_TRUE(writer.finish());
    return path;
  }

  TemporaryFolder folder_;
  fs::path input_;
};

class Convert : public ConvertedFiles, public ::testing::WithParamInterface<Named> {
 protected:
  [[nodiscard]] fs::path output() const { return folder_ / (is_one_file(GetParam().target) ? "out.mcap" : "out"); }
};

TEST_P(Convert, KeepsDepthToTheLastBit) {
  const ConvertSummary summary = convert(input_, GetParam().target, output());
  EXPECT_EQ(summary.frames, kFrames);
  EXPECT_EQ(summary.dropped, 0u);
  const Played before = play(input_, keep_all());
  const Played after = play(output(), keep_all());
  ASSERT_EQ(before.frames.size(), kFrames);
  ASSERT_EQ(after.frames.size(), kFrames);
  for (std::size_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(after.frames[i].depth_m, before.frames[i].depth_m);
    EXPECT_EQ(after.frames[i].intrinsics, before.frames[i].intrinsics);
  }
}

TEST_P(Convert, KeepsColour) {
  EXPECT_EQ(convert(input_, GetParam().target, output()).colour, kFrames);
  const Played before = play(input_, keep_all());
  const Played after = play(output(), keep_all());
  ASSERT_EQ(after.frames.size(), kFrames);
  for (std::size_t i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(after.frames[i].colour);
    EXPECT_EQ(after.frames[i].colour->image, before.frames[i].colour->image);
  }
}

TEST_P(Convert, KeepsTheJpegFilesByteByByte) {
  if (GetParam().target == ConvertTarget::kFakenect) GTEST_SKIP() << "a dump has no JPEG";
  (void)convert(input_, GetParam().target, output());
  const Played before = play(input_, keep_all());
  const Played after = play(output(), keep_all());
  for (std::size_t i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(after.frames.at(i).colour->encoded);
    EXPECT_EQ(*after.frames[i].colour->encoded, *before.frames[i].colour->encoded);
  }
}

TEST_P(Convert, KeepsPosesWhereTheTargetHasThem) {
  if (GetParam().target == ConvertTarget::kFakenect) GTEST_SKIP() << "a dump has no poses";
  EXPECT_EQ(convert(input_, GetParam().target, output()).poses, kFrames);
  const Played before = play(input_, keep_all());
  const Played after = play(output(), keep_all());
  constexpr double kRounding = 1e-14;  // a quaternion in between, and the nearest rotation
  for (std::size_t i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(after.frames.at(i).T_world_camera);
    EXPECT_TRUE(after.frames[i].T_world_camera->isApprox(*before.frames[i].T_world_camera, kRounding));
  }
}

TEST_P(Convert, KeepsTimesWhereTheTargetHasThem) {
  (void)convert(input_, GetParam().target, output());
  const Played before = play(input_, keep_all());
  const Played after = play(output(), keep_all());
  if (GetParam().target == ConvertTarget::kSevenScenes) {
    EXPECT_FALSE(after.frames.at(0).has_clock);
    return;
  }
  const std::int64_t digits_ns = GetParam().target == ConvertTarget::kFakenect ? 1000 : 1;  // microseconds in a name
  for (std::size_t i = 0; i < kFrames; ++i) {
    ASSERT_TRUE(after.frames.at(i).has_clock);
    EXPECT_LT(std::abs(after.frames[i].timestamp_ns - before.frames[i].timestamp_ns), digits_ns);
  }
}

TEST_P(Convert, NeverOverwritesARecording) {
  const fs::path precious = is_one_file(GetParam().target) ? output() : output() / "precious.txt";
  write_text(precious, "mine");
  auto source = open_recording(input_, keep_all());
  const auto summary = convert_recording(**source, GetParam().target, output());
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::kOutput);
  EXPECT_EQ(fs::file_size(precious), 4u);
  if (fs::is_directory(output())) {
    EXPECT_EQ(std::distance(fs::directory_iterator(output()), fs::directory_iterator()), 1);
  }
}

/// A scanner's disk that fails after the first frame.
class BrokenSource final : public FrameSource {
 public:
  explicit BrokenSource(FrameSource& source) : source_(source) {}
  [[nodiscard]] const RecordingInfo& info() const override { return source_.info(); }
  [[nodiscard]] FrameEvent next(std::stop_token stop) override {
    if (given_++ == 0) return source_.next(std::move(stop));
    return Error{ErrorCode::kInput, "broken"};
  }

 private:
  FrameSource& source_;
  int given_ = 0;
};

TEST_P(Convert, LeavesNothingOfWhatFailed) {
  auto source = open_recording(input_, keep_all());
  ASSERT_TRUE(source);
  BrokenSource broken(**source);
  EXPECT_FALSE(convert_recording(broken, GetParam().target, output()));
  EXPECT_FALSE(fs::exists(output()));
  if (is_one_file(GetParam().target)) return;
  fs::create_directories(output());
  auto again = open_recording(input_, keep_all());
  BrokenSource broken_again(**again);
  EXPECT_FALSE(convert_recording(broken_again, GetParam().target, output()));
  EXPECT_TRUE(fs::is_empty(output())) << "the folder was there, and is still";
}

TEST_P(Convert, WarnsOfPosesThatHaveNoPlace) {
  const ConvertSummary summary = convert(input_, GetParam().target, output());
  const bool is_told = std::any_of(summary.warnings.begin(), summary.warnings.end(),
                                   [](const std::string& text) { return text.find("no poses") != std::string::npos; });
  EXPECT_EQ(is_told, GetParam().target == ConvertTarget::kFakenect);
}

TEST_P(Convert, WarnsWhereColourHasToBeResampled) {
  EXPECT_FALSE(is_colour_resampled(convert(input_, GetParam().target, output())));
  const fs::path path = write_two_cameras();
  fs::remove_all(output());
  const ConvertSummary summary = convert(path, GetParam().target, output());
  EXPECT_EQ(summary.colour, 1u);
  EXPECT_EQ(is_colour_resampled(summary), !is_one_file(GetParam().target));
  fs::remove_all(output());
  EXPECT_FALSE(is_colour_resampled(convert(path, ConvertTarget::kColmap, output()))) << "its model is that of colour";
}

INSTANTIATE_TEST_SUITE_P(AllTargets, Convert,
                         ::testing::Values(Named{ConvertTarget::kMcap, "mcap"}, Named{ConvertTarget::kTum, "tum"},
                                           Named{ConvertTarget::kOpen3d, "open3d"},
                                           Named{ConvertTarget::kSevenScenes, "seven_scenes"},
                                           Named{ConvertTarget::kNerfstudio, "nerfstudio"},
                                           Named{ConvertTarget::kFakenect, "fakenect"},
                                           Named{ConvertTarget::kRos2, "ros2"}),
                         [](const auto& named) { return std::string(named.param.name); });

/// The rows of numbers and names of a text model of COLMAP.
std::vector<std::vector<std::string>> model_rows(const fs::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    rows.emplace_back(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>());
  }
  return rows;
}

class ConvertToColmap : public ConvertedFiles {};

TEST_F(ConvertToColmap, HoldsPicturesPosesAndPointsInTheirPlaces) {
  const ConvertSummary summary = convert(input_, ConvertTarget::kColmap, folder_ / "out");
  EXPECT_EQ(summary.frames, kFrames);
  EXPECT_TRUE(summary.warnings.empty());
  const Played before = play(input_, keep_all());
  const fs::path model = folder_ / "out/sparse/0";
  EXPECT_EQ(
      model_rows(model / "cameras.txt"),
      (std::vector<std::vector<std::string>>{{"1", "PINHOLE", "640", "480", "525.5", "524.5", "319.75", "240.25"}}));
  const auto images = model_rows(model / "images.txt");
  ASSERT_EQ(images.size(), kFrames);
  std::vector<Pose> views;
  for (std::size_t i = 0; i < kFrames; ++i) {
    const auto number = [&](std::size_t k) { return std::stod(images[i].at(k)); };
    Pose pose(Eigen::Translation3d(number(5), number(6), number(7)));
    pose.rotate(Eigen::Quaterniond(number(1), number(2), number(3), number(4)));
    EXPECT_TRUE(pose.inverse().isApprox(*before.frames.at(i).T_world_camera, 1e-12));
    views.push_back(pose);
    EXPECT_EQ(images[i].at(8), "1");
    EXPECT_EQ(bytes_of(folder_ / "out/images" / images[i].at(9)), *before.frames[i].colour->encoded);
  }
  const auto points = model_rows(model / "points3D.txt");
  ASSERT_GT(points.size(), 1000u);
  for (const auto& point : points) {
    const auto number = [&](std::size_t k) { return std::stod(point.at(k)); };
    const auto is_seen_in = [&](std::size_t i) {
      const Eigen::Vector3d p = views[i] * Eigen::Vector3d(number(1), number(2), number(3));
      const int x = static_cast<int>(std::floor(525.5 * p.x() / p.z() + 319.75));
      const int y = static_cast<int>(std::floor(524.5 * p.y() / p.z() + 240.25));
      if (p.z() <= 0 || x < 0 || y < 0 || x >= 640 || y >= 480) return false;
      const Rgb8& seen = before.frames[i].colour->image.at(x, y);
      return seen.r == number(4) && seen.g == number(5) && seen.b == number(6);
    };
    EXPECT_TRUE(is_seen_in(0) || is_seen_in(1) || is_seen_in(2)) << point.front();
  }
}

/// The numbers of a model's file by the first of each row; names apart.
std::map<double, std::vector<double>> model_numbers(const fs::path& file) {
  std::map<double, std::vector<double>> numbers;
  for (const auto& row : model_rows(file)) {
    for (std::size_t i = 1; i < row.size(); ++i) {
      if (std::isalpha(row[i].front()) == 0) numbers[std::stod(row.front())].push_back(std::stod(row[i]));
    }
  }
  return numbers;
}

TEST_F(ConvertToColmap, IsReadByColmap) {
  (void)convert(input_, ConvertTarget::kColmap, folder_ / "out");
  const fs::path model = folder_ / "out/sparse/0", again = folder_ / "again";
  fs::create_directories(again);
  const std::string command = "colmap model_converter --input_path '" + model.string() + "' --output_path '" +
                              again.string() + "' --output_type TXT";
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): one thread
  constexpr int kNoSuchCommand = 127;
  if (WEXITSTATUS(status) == kNoSuchCommand) GTEST_SKIP() << "SKIPPED: colmap is not installed (Debian package colmap)";
  ASSERT_EQ(status, 0);
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    const auto ours = model_numbers(model / name), theirs = model_numbers(again / name);
    EXPECT_FALSE(ours.empty()) << name;
    ASSERT_EQ(theirs.size(), ours.size()) << name;
    for (const auto& [number, row] : ours) {
      ASSERT_EQ(theirs.at(number).size(), row.size()) << name << " " << number;
      for (std::size_t i = 0; i < row.size(); ++i) {
        EXPECT_NEAR(theirs.at(number)[i], row[i], 1e-15 * std::max(1.0, std::abs(row[i])));  // its long doubles
      }
    }
  }
}

TEST_F(ConvertToColmap, LeavesOutFramesWithoutAPose) {
  fs::remove(input_ / "trajectory.log");
  auto source = open_recording(input_, keep_all());
  const auto summary = convert_recording(**source, ConvertTarget::kColmap, folder_ / "out");
  ASSERT_FALSE(summary);
  EXPECT_NE(summary.error().message.find("no pose"), std::string::npos) << summary.error().text();
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

class ConvertToRos2 : public ConvertedFiles {};

TEST_F(ConvertToRos2, IsDecodedByFoxglovesLibraries) {
  (void)convert(input_, ConvertTarget::kRos2, folder_ / "out.mcap");
  const std::string command = "node '" + kSourceDir + "/tests/acquire/read_ros2_bag.mjs' '" + kNpmDir + "' '" +
                              (folder_ / "out.mcap").string() + "' > '" + (folder_ / "said").string() + "'";
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): one thread
  constexpr int kSkipped = 77, kNoSuchCommand = 127;
  if (WEXITSTATUS(status) == kSkipped || WEXITSTATUS(status) == kNoSuchCommand) {
    GTEST_SKIP() << "SKIPPED: node or @mcap/core is not installed (npm ci in " << kNpmDir << ")";
  }
  ASSERT_EQ(status, 0);
  std::ifstream said(folder_ / "said");
  const auto bag = nlohmann::json::parse(said);
  EXPECT_EQ(bag.at("profile"), "ros2");
  const auto& topics = bag.at("topics");
  const Frame last = play(input_, keep_all()).frames.back();
  const auto of = [&](const char* topic, const char* type) {
    EXPECT_EQ(topics.at(topic).at("count"), kFrames) << topic;
    EXPECT_EQ(topics.at(topic).at("type"), type);
    return topics.at(topic).at("last");
  };
  const auto depth = of("/camera/depth/image_rect_raw", "sensor_msgs/msg/Image");
  EXPECT_EQ(depth.at("header").at("stamp").at("sec"), last.timestamp_ns / 1'000'000'000);
  EXPECT_EQ(depth.at("header").at("stamp").at("nanosec"), last.timestamp_ns % 1'000'000'000);
  EXPECT_EQ(depth.at("encoding"), "16UC1");
  EXPECT_EQ(depth.at("step"), 2 * 640);
  EXPECT_EQ(depth.at("data").at("length"), 2 * 640 * 480);
  const auto colour = of("/camera/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage");
  EXPECT_EQ(colour.at("format"), "jpeg");
  std::size_t sum = 0;
  for (const std::byte byte : *last.colour->encoded) sum += std::to_integer<std::size_t>(byte);
  EXPECT_EQ(colour.at("data").at("sum"), sum);
  const auto camera = of("/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo");
  EXPECT_EQ(camera.at("k"), nlohmann::json({525.5, 0, 319.25, 0, 524.5, 239.75, 0, 0, 1}));
  const auto transform = of("/tf", "tf2_msgs/msg/TFMessage").at("transforms").at(0);
  EXPECT_EQ(transform.at("child_frame_id"), depth.at("header").at("frame_id"));
  EXPECT_EQ(transform.at("transform").at("translation").at("x"), last.T_world_camera->translation().x());
  EXPECT_FALSE(topics.contains("/tf_static")) << "colour is registered to depth";
}

TEST_F(ConvertToRos2, KeepsTheColourCameraBesideDepth) {
  const fs::path path = write_two_cameras();
  (void)convert(path, ConvertTarget::kRos2, folder_ / "out.mcap");
  const Frame before = play(path, keep_all()).frames.at(0);
  const Frame after = play(folder_ / "out.mcap", keep_all()).frames.at(0);
  EXPECT_EQ(after.depth_m, before.depth_m);
  ASSERT_TRUE(after.colour);
  EXPECT_EQ(after.colour->image, before.colour->image);
  EXPECT_EQ(after.colour->intrinsics, before.colour->intrinsics);
  EXPECT_TRUE(after.colour->T_colour_depth.isApprox(before.colour->T_colour_depth, 1e-14));
}

class OwnRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    auto file = AppendFile::create(path_);
    RecordingWriter writer([&](std::span<const std::byte> bytes) { return file->append(bytes); }, raw_calibration());
    ASSERT_TRUE(writer.begin());
    for (std::uint32_t i = 0; i < 12; ++i) {
      ASSERT_TRUE(writer.write(depth_frame(i)));
      ASSERT_TRUE(writer.write(colour_frame(i)));
      if (i % 3 == 2) {
        ASSERT_TRUE(writer.flush());
      }
    }
    ASSERT_TRUE(writer.finish());
  }

  void cut(double part) const {
    auto bytes = bytes_of(path_);
    bytes.resize(static_cast<std::size_t>(part * static_cast<double>(bytes.size())));
    write_bytes(path_, bytes);
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "scan.mcap";
};

TEST_F(OwnRecording, ConvertedHasColourWhereDepthSeesIt) {
  const ConvertSummary summary = convert(path_, ConvertTarget::kOpen3d, folder_ / "out");
  EXPECT_TRUE(is_colour_resampled(summary));
  const Frame before = play(path_, keep_all()).frames.at(4);
  const Frame after = play(folder_ / "out", keep_all()).frames.at(4);
  EXPECT_EQ(after.depth_m, before.depth_m);
  ASSERT_EQ(after.colour->image.width(), before.depth_m.width());
  const double z = before.depth_m.at(24, 20);
  ASSERT_GT(z, 0);
  const Eigen::Vector2d pixel =
      before.colour->intrinsics.project(before.colour->T_colour_depth * before.intrinsics.unproject(24, 20, z));
  EXPECT_EQ(after.colour->image.at(24, 20), before.colour->image.at(static_cast<int>(std::lround(pixel.x())),
                                                                    static_cast<int>(std::lround(pixel.y()))));
}

TEST_F(OwnRecording, ConvertedToItsOwnKindKeepsItsColourCamera) {
  (void)convert(path_, ConvertTarget::kMcap, folder_ / "copy.mcap");
  const Frame before = play(path_).frames.at(4);
  const Frame after = play(folder_ / "copy.mcap").frames.at(4);
  EXPECT_EQ(after.depth_m, before.depth_m);
  EXPECT_EQ(after.colour->image, before.colour->image);
  EXPECT_EQ(after.colour->intrinsics, before.colour->intrinsics);
  EXPECT_EQ(after.colour->T_colour_depth.matrix(), before.colour->T_colour_depth.matrix());
}

TEST_F(OwnRecording, TornIsMendedInPlace) {
  cut(0.7);
  const std::size_t before = play(path_).frames.size();
  const auto summary = repair_recording(path_, path_, {});
  ASSERT_TRUE(summary) << summary.error().text();
  EXPECT_TRUE(summary->fault);
  EXPECT_EQ(summary->lost, 0u);
  auto source = open_recording(path_, {});
  EXPECT_TRUE((*source)->info().warnings.empty());
  EXPECT_EQ(play(**source).frames.size(), before);
}

TEST_F(OwnRecording, DamagedInTheMiddleLosesThatChunkOnly) {
  auto bytes = bytes_of(path_);
  bytes[bytes.size() / 2] ^= std::byte{4};
  write_bytes(path_, bytes);
  const auto summary = repair_recording(path_, folder_ / "mended.mcap", {});
  ASSERT_TRUE(summary);
  EXPECT_GT(summary->lost, 0u);
  EXPECT_EQ(bytes_of(path_), bytes) << "the input stays as it is";
  const Played mended = play(folder_ / "mended.mcap");
  EXPECT_EQ(mended.frames.size(), 9u);
  EXPECT_TRUE(mended.dropped.empty());
}

TEST_F(OwnRecording, MendedReplacesNoOtherFile) {
  const fs::path other = folder_ / "other.mcap";
  write_text(other, "mine");
  const auto summary = repair_recording(path_, other, {});
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::kOutput);
  EXPECT_EQ(fs::file_size(other), 4u);
}

TEST_F(OwnRecording, WholeIsNotChangedByMending) {
  const auto before = bytes_of(path_);
  const auto summary = repair_recording(path_, path_, {});
  ASSERT_TRUE(summary);
  EXPECT_FALSE(summary->fault);
  EXPECT_EQ(bytes_of(path_), before);
}

TEST_F(OwnRecording, CutInItsIndexLosesNothing) {
  auto bytes = bytes_of(path_);
  const auto whole = bytes;
  bytes.resize(bytes.size() - 100);
  write_bytes(path_, bytes);
  const auto summary = repair_recording(path_, path_, {});
  ASSERT_TRUE(summary);
  EXPECT_TRUE(summary->fault);
  EXPECT_EQ(bytes_of(path_), whole);
}

TEST_F(OwnRecording, InterruptedMendingLeavesItAsItWas) {
  cut(0.7);
  const auto before = bytes_of(path_);
  std::stop_source stop;
  stop.request_stop();
  const auto summary = repair_recording(path_, path_, {}, stop.get_token());
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::kTooLittle);
  EXPECT_EQ(bytes_of(path_), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()), 1);
}

TEST_F(OwnRecording, WithoutAWholeChunkCannotBeMended) {
  cut(0.05);
  EXPECT_FALSE(repair_recording(path_, path_, {}));
  EXPECT_TRUE(fs::exists(path_)) << "what there is stays";
}

// As the Kinect's recorder writes it: eleven bits of disparity.
TEST(FakenectDump, OfAKinectIsReadInMetres) {
  const TemporaryFolder folder;
  std::string depth = "P5 4 2 65535\n";
  for (const unsigned d : {0u, 500u, 700u, 900u, 1000u, 2046u, 2047u, 600u}) {
    depth += static_cast<char>(d & 0xFF);
    depth += static_cast<char>(d >> 8);
  }
  write_text(folder / "d-1263.500000-77.pgm", depth);
  write_text(folder / "INDEX.txt", "a-1263.4-76.dump\nd-1263.500000-77.pgm\n");
  AcquireConfig config = keep_all();
  config.intrinsics = CameraModel{{0, 0, 580, 580, 320, 240}, {}};
  const Played played = play(folder.path(), config);
  ASSERT_EQ(played.frames.size(), 1u);
  const Frame& frame = played.frames[0];
  EXPECT_EQ(frame.timestamp_ns, 1'263'500'000'000);
  // OpenKinect's table of measured distances, to its millimetre: 500 is 0.562 m, 900 is 1.759 m... by the formula.
  EXPECT_NEAR(frame.depth_m.at(1, 0), 0.1236 * std::tan(500 / 2842.5 + 1.1863), 0.0006);
  EXPECT_GT(frame.depth_m.at(3, 0), frame.depth_m.at(2, 0));
  EXPECT_EQ(frame.depth_m.at(2, 1), 0.0F) << "2047 is no return";
}

TEST(FakenectDump, CutAtAnyByteIsDropped) {
  const TemporaryFolder folder;
  const std::string whole = std::string("P5 4 2 65535\n") + std::string(16, '\1');
  write_text(folder / "INDEX.txt", "d-1.5-77.pgm\n");
  AcquireConfig config = keep_all();
  config.intrinsics = CameraModel{{0, 0, 580, 580, 320, 240}, {}};
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_text(folder / "d-1.5-77.pgm", whole.substr(0, size));
    EXPECT_EQ(play(folder.path(), config).reasons(), std::vector<std::string>{"unreadable"}) << size << " bytes";
  }
}

TEST(FakenectDump, NamesNoFileOutsideItsFolder) {
  const TemporaryFolder folder;
  write_text(folder / "d-1.5-77.pgm", "P5 4 2 65535\n" + std::string(16, '\1'));
  write_text(folder / "INDEX.txt", "d-1.5-../../../etc/passwd\n");
  EXPECT_NE(open_error(folder.path(), keep_all()), "");
}

#ifdef SCANKNIT_FAKENECT_CLIENT
std::uint32_t checksum(std::span<const std::byte> bytes) {
  std::uint32_t sum = 2166136261u;
  for (const std::byte b : bytes) sum = (sum ^ std::to_integer<std::uint32_t>(b)) * 16777619u;
  return sum;
}

using FakenectPlayer = Convert;

// libfreenect's own player, with a client that knows nothing of us.
TEST_P(FakenectPlayer, PlaysOurDumps) {
  if (!fs::exists(SCANKNIT_FAKENECT_PLAYER)) GTEST_SKIP() << "SKIPPED: no " << SCANKNIT_FAKENECT_PLAYER;
  (void)convert(input_, ConvertTarget::kFakenect, output());
  const std::string command = "FAKENECT_PATH='" + output().string() +
                              "' LD_PRELOAD=" SCANKNIT_FAKENECT_PLAYER " " SCANKNIT_FAKENECT_CLIENT " " +
                              std::to_string(kFrames);
  FILE* pipe = ::popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string printed;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe))
    printed.append(buffer.data(), count);
  EXPECT_EQ(::pclose(pipe), 0);
  std::istringstream lines(printed);
  std::vector<std::uint32_t> depth;
  char kind = 0;
  std::uint32_t sum = 0;
  while (lines >> kind >> sum) {
    if (kind == 'd') depth.push_back(sum);
  }
  ASSERT_EQ(depth.size(), kFrames) << printed;
  for (std::uint32_t i = 0; i < kFrames; ++i) EXPECT_EQ(depth[i], checksum(*depth_frame(i, 640, 480).bytes));
}

INSTANTIATE_TEST_SUITE_P(Dump, FakenectPlayer, ::testing::Values(Named{ConvertTarget::kFakenect, "fakenect"}),
                         [](const auto& named) { return std::string(named.param.name); });
#endif

}  // namespace
}  // namespace scanknit::test
