// A scanner whose depth camera stands beside the colour camera, from its recording to the pose between both.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/record/recorder.h"
#include "calibrate/board/board_pictures.h"
#include "calibrate/depth/measure_depth.h"
#include "calibrate/lens/bundle.h"
#include "core/rotation.h"
#include "synth/scene/board_scene.h"
#include "synth/synthetic_source.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

constexpr CameraIntrinsics kColour{640, 480, 525, 525, 319.5, 239.5};
constexpr CameraIntrinsics kDepth{320, 240, 290, 290, 158, 121};
constexpr int kPictures = 90;
constexpr double kRate_hz = 10;

/// The board, seen by a camera beside that of the scene's path.
class SeenFromBeside final : public SyntheticScene {
 public:
  SeenFromBeside(const SyntheticScene& scene, const Pose& T_scene_camera_own)
      : SyntheticScene(
            scene.name(),
            [path = scene.path(), T_scene_camera_own](double s) { return Pose(path(s) * T_scene_camera_own); },
            scene.default_frames()),
        scene_(scene) {}
  [[nodiscard]] std::optional<double> intersect(const Ray& ray, double max_t_m) const override {
    return scene_.intersect(ray, max_t_m);
  }
  [[nodiscard]] double distance(const Eigen::Vector3d& p_world) const override { return scene_.distance(p_world); }
  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p_world) const override { return scene_.nearest(p_world); }
  [[nodiscard]] Eigen::Vector3d colour(const SurfacePoint& point) const override { return scene_.colour(point); }
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return scene_.bounds(); }

 private:
  const SyntheticScene& scene_;
};

SyntheticScanner scanner_of(const SyntheticScene& scene, const CameraIntrinsics& camera) {
  SynthConfig config;
  config.frames = kPictures;
  config.intrinsics = camera;
  config.sensor = make_sensor("ideal").value();
  config.sensor->colour.noise = 0.01;
  return {scene, config};
}

RawFrame raw_frame(StreamProfile profile, int number, std::vector<std::byte> bytes) {
  const auto time_ns = static_cast<std::int64_t>(1e9 * (1 + number / kRate_hz));
  return {profile, static_cast<std::uint64_t>(number), time_ns, time_ns,
          std::make_shared<const std::vector<std::byte>>(std::move(bytes))};
}

RawFrame raw_depth(const DepthImage& depth_m, double unit_m, int number) {
  std::vector<std::byte> bytes(2 * depth_m.size());
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const auto units = static_cast<std::uint16_t>(std::lround(static_cast<double>(depth_m.pixels()[i]) / unit_m));
    std::memcpy(&bytes[2 * i], &units, sizeof units);
  }
  return raw_frame({StreamKind::kDepth, PixelFormat::kZ16, depth_m.width(), depth_m.height(), kRate_hz}, number,
                   std::move(bytes));
}

RawFrame raw_colour(const ColourImage& colour, int number) {
  std::vector<std::byte> bytes(3 * colour.size());
  for (std::size_t i = 0; i < colour.size(); ++i) {
    const Rgb8& p = colour.pixels()[i];
    const std::uint8_t rgb[] = {p.r, p.g, p.b};
    std::memcpy(&bytes[3 * i], rgb, sizeof rgb);
  }
  return raw_frame({StreamKind::kColour, PixelFormat::kRgb8, colour.width(), colour.height(), kRate_hz}, number,
                   std::move(bytes));
}

/// Depth in tenths of a millimetre. `stated`: what the recording says of T_colour_depth.
void record_board(const fs::path& file, const Pose& T_colour_depth, const Pose& stated) {
  const auto board = board_scene();
  ASSERT_TRUE(board) << board.error().text();
  const SeenFromBeside beside(**board, T_colour_depth);
  const SyntheticScanner colour = scanner_of(**board, kColour), depth = scanner_of(beside, kDepth);
  RawCalibration calibration;
  calibration.depth = {kDepth, {}};
  calibration.colour = {kColour, {}};
  calibration.T_colour_depth = stated;
  calibration.depth_unit_m = 0.0001;
  const auto recorder = Recorder::create(file, calibration, {.queue_frames = 4 * kPictures});
  ASSERT_TRUE(recorder) << recorder.error().text();
  for (int i = 0; i < kPictures; ++i) {
    const auto picture = static_cast<std::size_t>(i);
    (*recorder)->record(raw_depth(depth.shoot(picture).depth_m, calibration.depth_unit_m, i));
    (*recorder)->record(raw_colour(colour.shoot(picture).colour, i));
  }
  const auto summary = (*recorder)->finish();
  ASSERT_TRUE(summary) << summary.error().text();
}

TEST(MeasureDepth, FindsWhereADepthCameraStandsBesideColour) {
  PoseVector place, off;
  place << -0.015, 0.002, 0.004, 0.01, -0.02, 0.005;
  off << 0.004, -0.003, 0.002, 0.006, -0.004, 0.008;
  const Pose T_colour_depth = moved(place, Pose::Identity());
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "board.mcap";
  ASSERT_NO_FATAL_FAILURE(record_board(file, T_colour_depth, moved(off, T_colour_depth)));

  std::vector<BoardView> views;
  const auto look = [&](const BoardPicture& picture) -> Result<void> {
    auto sighting = find_board(picture.image, kSceneBoard);
    if (!sighting) return sighting.error();
    if (sighting->sight == BoardSight::kSeen)
      views.push_back({picture.name, std::move(sighting->corners), sighting->sharpness});
    return {};
  };
  const auto pictures = read_board_pictures(file, {}, look, {});
  ASSERT_TRUE(pictures) << pictures.error().text();
  ASSERT_FALSE(pictures->registered_depth) << "depth has a view of its own";
  const auto lens = calibrate_camera(views, kSceneBoard, {kColour.width, kColour.height});
  ASSERT_TRUE(lens) << lens.error().text();

  ScannerCamera cameras{.colour = lens->camera};
  const auto measured = measure_depth(file, {}, *pictures, views, *lens, kSceneBoard, {}, cameras);
  ASSERT_TRUE(measured) << measured.error().text();
  ASSERT_TRUE(cameras.T_colour_depth) << (measured->unknown.empty() ? "" : measured->unknown.front());
  const Pose left = *cameras.T_colour_depth * T_colour_depth.inverse();
  EXPECT_LT(left.translation().norm(), 0.0005);
  EXPECT_LT(Eigen::AngleAxisd(left.linear()).angle(), 0.05 * kDegree);
  ASSERT_TRUE(cameras.depth);
  EXPECT_EQ(cameras.depth->intrinsics, kDepth) << "as the recording states it";
  EXPECT_LT(measured->fit.after_m, measured->fit.before_m / 2);
}

}  // namespace
}  // namespace scanknit
