// Which sensor made a recording: by its names, and by the steps of its depth.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "acquire/sensor/recognise_sensor.h"
#include "acquire/sensor/sensor_profile.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr CameraIntrinsics kKinectCamera = {640, 480, 525, 525, 319.5, 239.5};
constexpr CameraIntrinsics kD435Camera = {640, 480, 385, 385, 320, 240};
constexpr double kKinectStep = 1 / (8 * 580 * 0.075);
constexpr double kD435Step = 1 / (32 * 385 * 0.05);

/// A floor that goes away, from 0.5 to 6 m, measured with noise in steps of `step` (1/m), delivered as whole units.
DepthImage measured_floor(double step, double units_per_m) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1);
  DepthImage depth_m(640, 480);
  for (int y = 0; y < depth_m.height(); ++y) {
    const double z = 0.5 + 5.5 * y / depth_m.height();
    for (int x = 0; x < depth_m.width(); ++x) {
      double inverse = 1 / z + 0.001 * noise(random);
      if (step > 0) inverse = step * std::round(inverse / step);
      depth_m.at(x, y) = static_cast<float>(std::round(units_per_m / inverse) / units_per_m);
    }
  }
  return depth_m;
}

SensorModel model_of(const std::optional<RecognisedSensor>& sensor) {
  return sensor ? sensor->model : SensorModel::kNone;
}

TEST(DisparityStep, IsFoundInWhateverUnitsTheFileHas) {
  for (const double units : {1000.0, 5000.0, 10000.0}) {
    const auto step = disparity_step_per_m(measured_floor(kKinectStep, units));
    ASSERT_TRUE(step.has_value()) << units;
    EXPECT_NEAR(*step, kKinectStep, 0.02 * kKinectStep) << units;
  }
}

TEST(SensorByDepth, IsAKinectByStepsOfAnEighthOfAPixel) {
  const auto sensor = sensor_by_depth(measured_floor(kKinectStep, 1000), kKinectCamera);
  EXPECT_EQ(model_of(sensor), SensorModel::kKinectV1);
  EXPECT_NE(sensor.value().reason.find("steps"), std::string::npos);
  EXPECT_TRUE(sensor.value().is_by_depth);
}

TEST(SensorByDepth, IsARealsenseByStepsOfAThirtySecondOfAPixel) {
  EXPECT_EQ(model_of(sensor_by_depth(measured_floor(kD435Step, 1000), kD435Camera)), SensorModel::kRealsenseD400);
}

TEST(SensorByDepth, LeavesDepthWithoutStepsUnrecognised) {
  EXPECT_FALSE(sensor_by_depth(measured_floor(0, 1000), kKinectCamera));
  EXPECT_FALSE(sensor_by_depth(measured_floor(0, 5000), kKinectCamera));
}

TEST(SensorByDepth, LeavesStepsOfOneSizeInDepthUnrecognised) {
  DepthImage depth_m = measured_floor(0, 1000);
  for (float& z : depth_m.pixels()) z = 0.01F * std::round(z * 100);  // a time-of-flight camera of 1 cm
  EXPECT_FALSE(sensor_by_depth(depth_m, kKinectCamera));
}

TEST(SensorByDepth, LeavesAKinectsStepsWithACameraThatNoKinectHasUnrecognised) {
  const CameraIntrinsics wide = {640, 480, 300, 300, 320, 240};
  EXPECT_FALSE(sensor_by_depth(measured_floor(kKinectStep, 1000), wide));
}

TEST(SensorByDepth, LeavesAnEmptyPictureUnrecognised) {
  EXPECT_FALSE(sensor_by_depth(DepthImage(640, 480), kKinectCamera));
}

TEST(SensorByName, KnowsWhatCamerasCallThemselves) {
  EXPECT_EQ(model_of(sensor_by_name({"mcap", {}, "Intel RealSense D435i"})), SensorModel::kRealsenseD400);
  EXPECT_EQ(model_of(sensor_by_name({"realsense-bag", {}, "Intel RealSense D455"})), SensorModel::kRealsenseD400);
  EXPECT_EQ(model_of(sensor_by_name({"live", {}, "Kinect for Xbox 360"})), SensorModel::kKinectV1);
  for (const char* format : {"phone-lidar", "stray-scanner", "arkitscenes", "polycam"}) {
    EXPECT_EQ(model_of(sensor_by_name({format, {}, {}})), SensorModel::kPhoneLidar) << format;
  }
}

TEST(SensorByName, LeavesOtherCamerasOfAMakerUnrecognised) {
  EXPECT_FALSE(sensor_by_name({"mcap", {}, "Intel RealSense D405"})) << "made for 7 to 50 cm";
  EXPECT_FALSE(sensor_by_name({"mcap", {}, "Intel RealSense SR300"}));
  EXPECT_FALSE(sensor_by_name({"mcap", {}, {}}));
}

TEST(SensorByName, KnowsTheTumSequencesByTheirFolders) {
  EXPECT_EQ(model_of(sensor_by_name({"tum", "/data/rgbd_dataset_freiburg1_desk", {}})), SensorModel::kTumFreiburg1);
  EXPECT_EQ(model_of(sensor_by_name({"tum", "/data/fr2_xyz/recording/", {}})), SensorModel::kTumFreiburg2);
  EXPECT_EQ(model_of(sensor_by_name({"tum", "Freiburg3-long-office", {}})), SensorModel::kTumFreiburg3);
  EXPECT_FALSE(sensor_by_name({"tum", "/data/fr10_desk", {}}));
  EXPECT_FALSE(sensor_by_name({"open3d", "/data/freiburg1_desk", {}})) << "converted pictures may be straightened";
}

TEST(SensorProfiles, AreFoundByTheirModel) {
  EXPECT_EQ(find_sensor(SensorModel::kNone), nullptr);
  for (const SensorProfile& profile : kSensorProfiles) {
    EXPECT_EQ(find_sensor(profile.model), &profile);
    EXPECT_LT(profile.min_depth_m, profile.max_depth_m) << profile.name;
  }
}

struct Made {
  const char* folder;
  SensorModel model;
};

TEST(RealRecordings, NameTheirSensorOrNone) {
  const Made made[] = {{"rgbd_tum_fr1_rpy_150", SensorModel::kTumFreiburg1},
                       {"rgbd_d435i_table_48", SensorModel::kRealsenseD400},
                       {"rgbd_iphone_lidar_corridor_73", SensorModel::kPhoneLidar},
                       {"rgbd_sun3d_studyroom_5/3dmatch", SensorModel::kKinectV1},
                       {"realsense_bag", SensorModel::kRealsenseD400},
                       {"pclzf", SensorModel::kKinectV1},
                       {"rgbd_box_f200", SensorModel::kNone},
                       {"rgbd_shelf_masks_15", SensorModel::kNone},
                       {"rgbd_redwood_lr1_211", SensorModel::kNone}};
  if (!fs::exists(data_folder())) GTEST_SKIP() << "SKIPPED: no recordings to read";
  for (const Made& recording : made) {
    const fs::path folder = data_folder() / recording.folder;
    if (!fs::exists(folder)) continue;
    AcquireConfig config;
    if (std::string_view(recording.folder) == "rgbd_shelf_masks_15") {
      config.intrinsics = CameraModel{{0, 0, 611.355, 611.4, 337.406, 247.190}, {}};
      config.depth_scale = 10000;
    }
    const auto source = open_recording(folder, config);
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_EQ(model_of((*source)->info().sensor), recording.model) << recording.folder;
  }
}

}  // namespace
}  // namespace scanknit::test
