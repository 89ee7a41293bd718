// Sensors in time: shutters, late colour, lost frames, and what a recording says of them.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "synth/sensor/sense_colour.h"
#include "synth/sensor/sensor_keys.h"
#include "synth/synthetic_source.h"
#include "synth/truth_files.h"
#include "synth/write_recording.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

SynthConfig small_config(const RenderedSensor& sensor = {}) {
  SynthConfig config;
  config.frames = 6;
  config.sensor = sensor;
  config.intrinsics = camera_of(sensor, 80, 60);
  config.truth_points = 2000;
  config.min_views = 1;
  return config;
}

/// The ideal sensor with some values changed.
RenderedSensor with(const std::vector<std::string>& assignments) {
  RenderedSensor sensor;
  for (const std::string& assignment : assignments) EXPECT_TRUE(set_sensor_value(sensor, assignment)) << assignment;
  return sensor;
}

/// Straight ahead, or to the right, at one metre a second.
std::vector<PathPose> at_one_metre_a_second(const Eigen::Vector3d& direction) {
  Pose end = Pose::Identity();
  end.translation() = 4 * direction;
  return {{0, Pose::Identity()}, {4, end}};
}

TEST(IdealSensor, MakesTheSamePicturesAsNoSensor) {
  const auto scene = *make_scene("desk");
  SynthConfig config = small_config();
  const Shot ideal = SyntheticScanner(*scene, config).shoot(3);
  config.sensor.reset();
  const Shot none = SyntheticScanner(*scene, config).shoot(3);
  EXPECT_EQ(ideal.depth_m, none.depth_m);
  EXPECT_EQ(ideal.colour, none.colour);
  EXPECT_EQ(ideal.T_world_camera.matrix(), none.T_world_camera.matrix());
}

TEST(RollingShutter, SeesEachRowWhereTheCameraIsThen) {
  const auto scene = *make_scene("bare_wall");
  constexpr double kReadout_s = 0.030;
  SynthConfig config = small_config(with({"shutter.depth=30ms"}));
  config.recorded_path = at_one_metre_a_second({0, 0, 1});
  const Shot rolling = SyntheticScanner(*scene, config).shoot(3);
  config.sensor = RenderedSensor();
  const Shot global = SyntheticScanner(*scene, config).shoot(3);
  EXPECT_EQ(rolling.T_world_camera.matrix(), global.T_world_camera.matrix()) << "that of the middle row";
  const int bands = 60 / 12;
  for (int y = 0; y < 60; ++y) {
    std::vector<double> nearer;
    for (int x = 0; x < 80; ++x) {
      nearer.push_back(static_cast<double>(global.depth_m.at(x, y)) - static_cast<double>(rolling.depth_m.at(x, y)));
    }
    std::nth_element(nearer.begin(), nearer.begin() + 40, nearer.end());
    const double expected_m = kReadout_s * ((y + 0.5) / 60 - 0.5);  // at 1 m/s
    EXPECT_NEAR(nearer[40], expected_m, 0.6 * kReadout_s / bands) << y;
  }
}

TEST(ColourDelay, ShowsTheColoursOfALaterMoment) {
  const auto scene = *make_scene("desk");
  const SynthConfig late = small_config(with({"colour.delay=100ms", "time.rate=10Hz"}));
  const SyntheticScanner scanner(*scene, late);
  EXPECT_EQ(scanner.shoot(1).colour, scanner.shoot(2).exact.colour);
  EXPECT_NE(scanner.shoot(1).colour, scanner.shoot(1).exact.colour);
}

/// The mean squared step between neighbours in a row: less where edges are spread over several pixels.
double sharpness(const ColourImage& picture) {
  double sum = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x + 1 < picture.width(); ++x) sum += std::pow(picture.at(x, y).g - picture.at(x + 1, y).g, 2);
  }
  return sum / static_cast<double>(picture.size());
}

TEST(MotionBlur, BlursWhatMovesOnly) {
  const auto scene = *make_scene("desk");
  SynthConfig config = small_config(with({"colour.exposure=30ms"}));
  config.intrinsics = camera_of(*config.sensor, 320, 240);  // fine enough to resolve the textures
  config.recorded_path = at_one_metre_a_second({1, 0, 0});
  const Shot moving = SyntheticScanner(*scene, config).shoot(3);
  EXPECT_LT(sharpness(moving.colour), 0.8 * sharpness(moving.exact.colour));
  config.recorded_path.back().T_world_camera = Pose::Identity();
  const Shot still = SyntheticScanner(*scene, config).shoot(3);
  EXPECT_EQ(still.colour, still.exact.colour);
}

TEST(LostFrames, LeaveGapsInTheTimesAndTakeTheirPosesAlong) {
  const auto scene = *make_scene("desk");
  SynthConfig config = small_config(with({"time.dropped=40%"}));
  config.frames = 200;
  const SyntheticScanner scanner(*scene, config);
  EXPECT_NEAR(static_cast<double>(scanner.pictures()), 120, 4 * std::sqrt(200 * 0.24));
  const auto poses = camera_path(*scene, 200);
  std::size_t gaps = 0;
  for (std::size_t i = 0; i < scanner.pictures(); ++i) {
    const std::size_t stamp = scanner.times()[i].stamp;
    EXPECT_EQ(scanner.timestamp_ns(i), std::llround(1e9 * static_cast<double>(stamp) / 30));
    gaps += i > 0 && stamp != scanner.times()[i - 1].stamp + 1 ? 1 : 0;
  }
  EXPECT_GT(gaps, 20u);
  EXPECT_EQ(scanner.shoot(50).T_world_camera.matrix(), poses[scanner.times()[50].stamp].matrix());
}

TEST(RepeatedFrames, ShowOldPicturesAtNewTimes) {
  const auto scene = *make_scene("desk");
  SynthConfig config = small_config(
      with({"time.repeated=50%", "disparity.baseline=5cm", "disparity.focal=600px", "disparity.noise=0.2px"}));
  config.frames = 20;
  const SyntheticScanner scanner(*scene, config);
  ASSERT_EQ(scanner.pictures(), 20u);
  const auto& times = scanner.times();
  const auto repeated =
      std::find_if(times.begin(), times.end(), [](const FrameTime& time) { return time.taken != time.stamp; });
  ASSERT_NE(repeated, times.end());
  const auto number = static_cast<std::size_t>(repeated - times.begin());
  const Shot before = scanner.shoot(number - 1);
  const Shot again = scanner.shoot(number);
  EXPECT_EQ(again.depth_m, before.depth_m) << "noise included";
  EXPECT_EQ(again.colour, before.colour);
  EXPECT_NE(again.T_world_camera.matrix(), before.T_world_camera.matrix()) << "the truth is that of the time stamp";
}

TEST(Lens, BendsThePictureAndIsInvertedByTheTruthPoints) {
  const CameraIntrinsics camera{320, 240, 262.5, 262.5, 159.5, 119.5};
  const ViewCamera bent(camera, {.k1 = 0.1, .k2 = -0.05}, {Pose::Identity()});
  const ViewCamera ideal(camera, Pose::Identity());
  for (const auto& [x, y] : {std::pair{0, 0}, {30, 200}, {159, 119}, {319, 120}}) {
    const auto seen = bent.see(2 * bent.through(x, y));
    ASSERT_TRUE(seen);
    EXPECT_NEAR((seen->pixel - Eigen::Vector2d(x, y)).norm(), 0, 1e-6);
  }
  EXPECT_GT((ideal.see(bent.through(0, 0))->pixel - Eigen::Vector2d(0, 0)).norm(), 3);
}

TEST(ColourCamera, TakesDarkAndBrightPicturesToAMiddleGrey) {
  const ColourModel model{.adaptation = 1};
  for (const int level : {40, 110, 220}) {
    const auto grey = static_cast<std::uint8_t>(level);
    const ColourImage sensed = sense_colour(ColourImage(64, 48, {grey, grey, grey}), model, 1, 0);
    EXPECT_EQ(sensed.at(10, 10), (Rgb8{110, 110, 110})) << level;
  }
}

TEST(ColourCamera, BalancesWhite) {
  const ColourImage reddish(64, 48, {160, 110, 60});
  const Rgb8 whole = sense_colour(reddish, {.white_balance = 1}, 1, 0).at(0, 0);
  EXPECT_EQ(whole, (Rgb8{110, 110, 110}));
  const Rgb8 half = sense_colour(reddish, {.white_balance = 0.5}, 1, 0).at(0, 0);
  EXPECT_LT(half.r, 160);
  EXPECT_GT(half.r, 110);
}

TEST(ColourCamera, HasTheStatedNoise) {
  const ColourImage sensed = sense_colour(ColourImage(320, 240, {128, 128, 128}), {.noise = 0.02}, 1, 0);
  double squares = 0;
  for (const Rgb8& colour : sensed.pixels()) squares += std::pow(colour.g - 128.0, 2);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(sensed.size())), 0.02 * 255, 0.1);
}

TEST(Person, MovesThroughThePictureAndIsNoPartOfTheTruth) {
  const auto scene = *make_scene("clutter");
  SynthConfig config = small_config();
  config.frames = 0;
  const Shot empty = SyntheticScanner(*scene, config).shoot(0);
  config.person = PersonKind::kWalking;
  const SyntheticScanner scanner(*scene, config);
  const auto pixels_of_person = [&](const Shot& shot) {
    double nearer = 0;
    for (std::size_t i = 0; i < shot.depth_m.size(); ++i) {
      EXPECT_LE(shot.depth_m.pixels()[i], empty.depth_m.pixels()[i]);
      nearer += shot.depth_m.pixels()[i] < empty.depth_m.pixels()[i] ? 1 : 0;
    }
    return nearer;
  };
  const Shot with_person = scanner.shoot(0);
  EXPECT_GT(pixels_of_person(with_person), 50);
  config.person = PersonKind::kSitting;
  EXPECT_NE(SyntheticScanner(*scene, config).shoot(0).depth_m, with_person.depth_m);
}

TEST(SensorRecording, IsTheSameForAnyNumberOfThreads) {
  const auto scene = *make_scene("clutter");
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    SynthConfig config = small_config(*make_sensor("kinect1"));
    config.path = PathKind::kTurns;
    config.person = PersonKind::kWalking;
    return SyntheticScanner(*scene, config).shoot(2);
  };
  const Shot one = with_threads(1);
  const Shot eight = with_threads(8);
  EXPECT_EQ(one.depth_m, eight.depth_m);
  EXPECT_EQ(one.colour, eight.colour);
}

TEST(SensorRecording, StatesWhatTheSensorBelievesAndKeepsTheTruth) {
  const test::TemporaryFolder folder;
  const SynthConfig config = small_config(*make_sensor("kinect1"));
  ASSERT_TRUE(write_synthetic_recording(**make_scene("clutter"), config, folder.path()));
  const auto stated = nlohmann::json::parse(test::read_text(folder / "camera_intrinsic.json"));
  EXPECT_DOUBLE_EQ(stated["intrinsic_matrix"][0], 1.004 * config.intrinsics.fx);
  EXPECT_EQ(stated["depth_scale"], 5000);
  const auto truth = nlohmann::json::parse(test::read_text(folder / "ground_truth.json"));
  EXPECT_EQ(truth["true_camera"]["fx"], config.intrinsics.fx);
  EXPECT_EQ(truth["sensor"]["name"], "kinect1");
  EXPECT_EQ(truth["sensor"]["values"]["disparity.step"], 0.125);
  EXPECT_EQ(test::read_text(folder / "timestamps.txt").substr(0, 12), "0.000000000\n");
  EXPECT_TRUE(read_truth(folder.path()));
}

TEST(SensorRecording, CountsThePointsThatARollingShutterSees) {
  const auto scene = *make_scene("desk");
  const auto visible = [&](const RenderedSensor& sensor) {
    const test::TemporaryFolder folder;
    SynthConfig config = small_config(sensor);
    config.path = PathKind::kTurns;
    config.truth_points = 20'000;
    config.frames = 40;
    return static_cast<double>(write_synthetic_recording(*scene, config, folder.path())->visible_points);
  };
  const double ideal = visible({});
  EXPECT_NEAR(visible(with({"shutter.depth=30ms", "lens.k1=0.05"})), ideal, 0.03 * ideal);
}

TEST(SensorRecording, ReachesAcrossTheHallInMillimetres) {
  const auto scene = *make_scene("hall");
  SynthConfig config = small_config(*make_sensor("d435"));
  const Shot shot = SyntheticScanner(*scene, config).shoot(0);
  const auto pixels = shot.exact.depth_m.pixels();
  EXPECT_GT(*std::max_element(pixels.begin(), pixels.end()), 25);
  EXPECT_LT(*std::min_element(pixels.begin(), pixels.end()), 1);
  EXPECT_EQ(units_per_metre(config), 1000);
}

TEST(SensorConfig, RefusesWhatDoesNotGoTogether) {
  SynthConfig config = small_config();
  config.noise = true;
  EXPECT_FALSE(validate(config));
  config = small_config();
  config.turntable = RigConfig{};
  EXPECT_TRUE(validate(config));
  config.path = PathKind::kHand;
  EXPECT_FALSE(validate(config));
  config = small_config();
  config.sensor->edges.dropout = 2;
  ASSERT_FALSE(validate(config));
  EXPECT_NE(validate(config).error().message.find("edges.dropout: '2'"), std::string::npos);
}

TEST(SensorSource, GivesFramesWithAClockAndTheStatedCamera) {
  const SynthConfig config = small_config(with({"camera.focal=1%"}));
  const auto source = SyntheticSource::create(*make_scene("desk"), config);
  ASSERT_TRUE(source);
  (void)(*source)->next({});
  const FrameEvent event = (*source)->next({});
  const Frame& frame = std::get<Frame>(event);
  EXPECT_TRUE(frame.has_clock);
  EXPECT_EQ(frame.timestamp_ns, 33'333'333);
  EXPECT_DOUBLE_EQ(frame.intrinsics.fx, 1.01 * config.intrinsics.fx);
}

}  // namespace
}  // namespace scanknit
