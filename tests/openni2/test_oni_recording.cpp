// Files of OpenNI2's own recorder, read by ourselves.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "acquire/frame_source.h"
#include "acquire/layouts/oni_file.h"
#include "export/mesh/read_mesh.h"
#include "synth/surface_error.h"
#include "tests/app/program.h"
#include "tests/openni2/emulated_pictures.h"
#include "tests/openni2/oni_recorder.h"

namespace scanknit::test {
namespace {

OniFile open_oni(const std::filesystem::path& path) {
  return OniFile::open(open_random_access(path).value(), {}).value();
}

AcquireConfig tracked() {
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  return config;
}

template <typename T>
bool equal(const RawFrame& frame, const std::vector<T>& expected) {
  return frame.bytes->size() == expected.size() * sizeof(T) &&
         std::memcmp(frame.bytes->data(), expected.data(), frame.bytes->size()) == 0;
}

/// The number of the emulated picture that `frame` is, bit by bit; none: kEmulatedPictures.
std::size_t number_of(const RawFrame& frame) {
  std::size_t n = 0;
  const auto is_this = [&](const EmulatedPicture& picture) {
    return frame.profile.kind == StreamKind::kDepth ? equal(frame, picture.depth_mm) : equal(frame, picture.rgb);
  };
  while (n < kEmulatedPictures && !is_this(emulated_picture(n))) ++n;
  return n;
}

void expect_all_of(const OniFile& file, StreamKind kind) {
  const OniStream& stream = kind == StreamKind::kDepth ? file.depth() : *file.colour();
  ASSERT_GE(stream.pictures.size(), 10u);
  std::size_t last = kEmulatedPictures;
  for (std::size_t i = 0; i < stream.pictures.size(); ++i) {
    const auto frame = file.read(kind, i);
    ASSERT_TRUE(frame) << frame.error().text();
    const std::size_t n = number_of(*frame);
    ASSERT_LT(n, kEmulatedPictures) << "picture " << i << " is none of the camera's";
    if (i > 0) {
      EXPECT_EQ(std::max(n, last) - std::min(n, last), 1u) << "a neighbour in the walk there and back";
      EXPECT_NEAR(static_cast<double>(stream.pictures[i].time_us - stream.pictures[i - 1].time_us), 33333, 1);
    }
    last = n;
  }
}

TEST(OniRecording, HoldsEveryPictureBitByBit) {
  const TempFolder folder;
  ASSERT_TRUE(record_oni(folder / "desk.oni"));
  const OniFile file = open_oni(folder / "desk.oni");
  EXPECT_FALSE(file.fault()) << *file.fault();
  EXPECT_EQ(file.depth().coding, OniCoding::kDepthStepsTable);
  expect_all_of(file, StreamKind::kDepth);
  expect_all_of(file, StreamKind::kColour);
}

TEST(OniRecording, MirroredIsTurnedBack) {
  const TempFolder folder;
  ASSERT_TRUE(record_oni(folder / "desk.oni", {.is_mirrored = true}));
  const OniFile file = open_oni(folder / "desk.oni");
  EXPECT_TRUE(file.depth().is_mirrored);
  expect_all_of(file, StreamKind::kDepth);
  expect_all_of(file, StreamKind::kColour);
}

TEST(OniRecording, LossyColourIsNearTheTruth) {
  const TempFolder folder;
  ASSERT_TRUE(record_oni(folder / "desk.oni", {.is_lossy = true}));
  const auto source = open_recording(folder / "desk.oni", tracked());
  ASSERT_TRUE(source) << source.error().text();
  const FrameEvent event = (*source)->next({});
  ASSERT_TRUE(std::holds_alternative<Frame>(event));
  const Frame& frame = std::get<Frame>(event);
  ASSERT_TRUE(frame.colour);
  // The first picture of the file is one of the camera's first.
  double best = 255;
  for (std::size_t n = 0; n < 8; ++n) {
    double sum = 0;
    const auto pixels = frame.colour->image.pixels();
    for (std::size_t i = 0; i < pixels.size(); ++i) sum += std::abs(pixels[i].g - emulated_picture(n).rgb[3 * i + 1]);
    best = std::min(best, sum / static_cast<double>(pixels.size()));
  }
  constexpr double kJpegError = 4;  // of 255, in the mean
  EXPECT_LT(best, kJpegError);
}

TEST(OniRecording, KnowsItsCamera) {
  const TempFolder folder;
  ASSERT_TRUE(record_oni(folder / "desk.oni"));
  const auto source = open_recording(folder / "desk.oni", tracked());
  ASSERT_TRUE(source) << source.error().text();
  const RecordingInfo& info = (*source)->info();
  EXPECT_EQ(info.format, "oni");
  EXPECT_TRUE(info.has_colour);
  EXPECT_EQ(info.depth_scale, 1000);
  ASSERT_TRUE(info.intrinsics);
  constexpr double kOfFloatAngles = 1e-3;  // pixels
  EXPECT_EQ(info.intrinsics->width, kEmulatedCamera.width);
  EXPECT_NEAR(info.intrinsics->fx, kEmulatedCamera.fx, kOfFloatAngles);
  EXPECT_NEAR(info.intrinsics->fy, kEmulatedCamera.fy, kOfFloatAngles);
  EXPECT_EQ(info.intrinsics->cx, kEmulatedCamera.cx);
  EXPECT_EQ(info.intrinsics->cy, kEmulatedCamera.cy);
}

/// False: on a busy machine the recorder missed the first picture of depth or colour, and took the next ones for pairs.
bool begins_with_a_pair(const OniFile& file) {
  return number_of(file.read(StreamKind::kDepth, 0).value()) == number_of(file.read(StreamKind::kColour, 0).value());
}

TEST(OniRecording, BecomesAMesh) {
  constexpr int kMostTries = 5;
  const TempFolder folder;
  bool is_paired = false;
  for (int tries = 0; tries < kMostTries && !is_paired; ++tries) {
    std::filesystem::remove((folder / "desk.oni").string());
    ASSERT_TRUE(record_oni(folder / "desk.oni", {.pictures = 14}));
    is_paired = begins_with_a_pair(open_oni(folder / "desk.oni"));
  }
  ASSERT_TRUE(is_paired);
  const Outcome run = scanknit_command(
      {"run", (folder / "desk.oni").string(), "-o", (folder / "desk.ply").string(), "--set", "fusion.voxel_size=8mm"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  // Tracked: in the frame of the first camera, which is the camera's place in the file's first picture.
  auto mesh = read_mesh(folder / "desk.ply");
  ASSERT_TRUE(mesh);
  const std::size_t first = number_of(open_oni(folder / "desk.oni").read(StreamKind::kDepth, 0).value());
  const Eigen::Isometry3f T_world_mesh = emulated_picture(first).T_world_camera.cast<float>();
  for (Eigen::Vector3f& p : mesh->positions_m) p = T_world_mesh * p;
  const auto error = measure_surface(*mesh, emulated_scene(), {});
  ASSERT_TRUE(error);
  constexpr double kQuarterVoxel_m = 0.002;
  EXPECT_LT(error->vertices.mean_m, kQuarterVoxel_m);
}

}  // namespace
}  // namespace scanknit::test
