// What a configuration leaves to the sensor.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/sensor/sensor_profile.h"
#include "scan/frames/apply_sensor.h"

namespace scanknit {
namespace {

/// Keeps what the user is told.
class Listener final : public ScanObserver {
 public:
  void on_message(LogLevel, std::string_view text) override { lines.emplace_back(text); }
  std::vector<std::string> lines;
};

ScanConfig applied(ScanConfig config, SensorModel recognised, std::vector<std::string>* lines = nullptr,
                   bool is_by_depth = false) {
  Listener listener;
  ScanSession session(listener, {});
  const RecognisedSensor sensor{recognised, "it says so", is_by_depth};
  apply_sensor(recognised == SensorModel::kNone ? std::nullopt : std::optional(sensor), config, session);
  if (lines != nullptr) *lines = listener.lines;
  return config;
}

ScanConfig with_voxels(double voxel_size_m) {
  ScanConfig config;
  config.fusion.voxel_size_m = voxel_size_m;
  return config;
}

TEST(AppliedSensor, GivesItsNoiseAndTheBeginOfItsRange) {
  const SensorProfile& d400 = *find_sensor(SensorModel::kRealsenseD400);
  const ScanConfig config = applied({}, SensorModel::kRealsenseD400);
  EXPECT_EQ(config.acquire.sensor, SensorModel::kRealsenseD400);
  EXPECT_EQ(config.fusion.noise, d400.noise);
  EXPECT_EQ(config.acquire.min_depth_m, d400.min_depth_m);
}

TEST(AppliedSensor, GivesItsTimingUnlessItIsGiven) {
  const FrameTiming kinect = find_sensor(SensorModel::kKinectV1)->timing;
  ScanConfig config = applied({}, SensorModel::kKinectV1);
  EXPECT_EQ(config.acquire.readout_s, kinect.readout_s);
  EXPECT_EQ(config.acquire.colour_later_s, kinect.colour_later_s);
  EXPECT_GT(kinect.readout_s, 0);
  config.acquire.readout_s = 0;
  config.acquire.sensor.reset();
  EXPECT_EQ(applied(config, SensorModel::kKinectV1).acquire.readout_s, 0);
  EXPECT_TRUE(applied({}, SensorModel::kNone).acquire.timing().is_at_once());
}

TEST(AppliedSensor, TakesTheTimeBetweenBothCamerasFromTheScannersCalibrationUnlessItIsGiven) {
  ScannerCamera camera;
  camera.colour_later_s = -0.004;
  ScanConfig config;
  config.acquire.camera = std::make_shared<const ScannerCamera>(camera);
  for (const SensorModel sensor : {SensorModel::kNone, SensorModel::kKinectV1}) {
    const AcquireConfig acquire = applied(config, sensor).acquire;
    EXPECT_EQ(acquire.colour_later_s, -0.004);
    EXPECT_EQ(acquire.timing().colour_later_s, -0.004);
  }
  EXPECT_EQ(applied(config, SensorModel::kKinectV1).acquire.readout_s,
            find_sensor(SensorModel::kKinectV1)->timing.readout_s);
  config.acquire.colour_later_s = 0.02;
  EXPECT_EQ(applied(config, SensorModel::kKinectV1).acquire.colour_later_s, 0.02);
  config.acquire.colour_later_s.reset();
  config.acquire.camera = std::make_shared<const ScannerCamera>();
  EXPECT_EQ(applied(config, SensorModel::kKinectV1).acquire.colour_later_s,
            find_sensor(SensorModel::kKinectV1)->timing.colour_later_s)
      << "not stated there";
}

/// What apply_sensor() says of the timing of a Kinect that was recognised by its depth alone.
std::optional<FrameTiming> possible_timing(ScanConfig config) {
  Listener listener;
  ScanSession session(listener, {});
  return apply_sensor(RecognisedSensor{SensorModel::kKinectV1, "it says so", /*is_by_depth=*/true}, config, session);
}

TEST(AppliedSensor, GivesOnlyAPossibleTimingWhereItIsRecognisedByItsDepthAlone) {
  const ScanConfig config = applied({}, SensorModel::kKinectV1, nullptr, /*is_by_depth=*/true);
  EXPECT_EQ(config.acquire.sensor, SensorModel::kKinectV1);
  EXPECT_TRUE(config.acquire.timing().is_at_once());
  const auto possible = possible_timing({});
  ASSERT_TRUE(possible);
  EXPECT_EQ(possible->readout_s, find_sensor(SensorModel::kKinectV1)->timing.readout_s);
  ScanConfig given;
  given.acquire.readout_s = 0;
  EXPECT_FALSE(possible_timing(given));
}

TEST(AppliedSensor, EndsDepthWhereTheNoiseExceedsSomeVoxels) {
  const ScanConfig config = applied(with_voxels(0.002), SensorModel::kRealsenseD400);
  const double sigma_m = config.fusion.noise.sigma_m(*config.acquire.max_depth_m);
  EXPECT_LE(sigma_m, kMostNoiseVoxels * 0.002);
  EXPECT_GT(sigma_m, kMostNoiseVoxels * 0.002 * 0.95) << "no nearer than it must";
}

TEST(AppliedSensor, EndsDepthWithTheSensorsRangeAtLargeVoxels) {
  EXPECT_EQ(applied(with_voxels(0.03), SensorModel::kKinectV1).acquire.max_depth_m, 4);
}

TEST(AppliedSensor, EndsDepthOfAnUnknownSensorByAKinectsNoise) {
  const ScanConfig config = applied(with_voxels(0.01), SensorModel::kNone);
  EXPECT_EQ(config.acquire.sensor, SensorModel::kNone);
  EXPECT_EQ(config.acquire.min_depth_m, 0);
  EXPECT_NEAR(NoiseModel{}.sigma_m(*config.acquire.max_depth_m), kMostNoiseVoxels * 0.01, 0.001);
}

TEST(AppliedSensor, KeepsARangeAtVoxelsFinerThanItsNoise) {
  for (const SensorProfile& profile : kSensorProfiles) {
    const ScanConfig config = applied(with_voxels(0.0002), profile.model);
    EXPECT_GT(*config.acquire.max_depth_m, *config.acquire.min_depth_m) << profile.name;
  }
}

TEST(AppliedSensor, ChangesNothingThatIsGiven) {
  ScanConfig given = with_voxels(0.002);
  given.acquire.min_depth_m = 0.1;
  given.acquire.max_depth_m = 0;  // no limit
  given.noise = {0.003, 0.004, 0.5};
  const ScanConfig config = applied(given, SensorModel::kRealsenseD400);
  EXPECT_EQ(config.acquire.min_depth_m, 0.1);
  EXPECT_EQ(config.acquire.max_depth_m, 0);
  EXPECT_EQ(config.fusion.noise, (NoiseModel{0.003, 0.004, 0.5}));
}

TEST(AppliedSensor, IsTheGivenOneWhateverWasRecognised) {
  ScanConfig given;
  given.acquire.sensor = SensorModel::kPhoneLidar;
  EXPECT_EQ(applied(given, SensorModel::kKinectV1).fusion.noise, kPhoneNoise);
  given.acquire.sensor = SensorModel::kNone;
  EXPECT_EQ(applied(given, SensorModel::kRealsenseD400).fusion.noise, NoiseModel{});
}

TEST(AppliedSensor, TakesANoiseThatIsGivenInPart) {
  ScanConfig given;
  given.noise.floor_m = 0.002;
  const NoiseModel noise = applied(given, SensorModel::kRealsenseD400).fusion.noise;
  EXPECT_EQ(noise.floor_m, 0.002);
  EXPECT_EQ(noise.growth_per_m, kStereoNoise.growth_per_m);
}

TEST(AppliedSensor, IsAppliedOnce) {
  const ScanConfig once = applied(with_voxels(0.002), SensorModel::kRealsenseD400);
  std::vector<std::string> lines;
  const ScanConfig twice = applied(once, SensorModel::kNone, &lines);
  EXPECT_EQ(twice.acquire.max_depth_m, once.acquire.max_depth_m);
  EXPECT_EQ(twice.fusion.noise, once.fusion.noise);
  EXPECT_TRUE(lines.empty());
}

TEST(AppliedSensor, SaysInALineEachWhatWasChosenAndWhichKeyChangesIt) {
  std::vector<std::string> lines;
  (void)applied(with_voxels(0.002), SensorModel::kRealsenseD400, &lines);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "sensor: realsense_d400, because it says so; acquire.sensor=none treats it as unknown");
  EXPECT_EQ(lines[1],
            "depth beyond 1.48 m is left out: there the noise exceeds 5 voxels of 2 mm; acquire.max_depth=... keeps "
            "more");
}

}  // namespace
}  // namespace scanknit
