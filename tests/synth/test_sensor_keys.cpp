#include <gtest/gtest.h>

#include <set>
#include <string>

#include "synth/sensor/sensor_keys.h"
#include "synth/sensor/sensor_names.h"

namespace scanknit {
namespace {

/// The error's text; empty if there is none.
std::string error_of(const std::string& assignment) {
  RenderedSensor sensor = *make_sensor("kinect1");
  const auto done = set_sensor_value(sensor, assignment);
  return done ? "" : done.error().message;
}

TEST(SensorKeys, HaveNamesAndPlacesOfTheirOwn) {
  std::set<std::string_view> names;
  std::set<const double*> places;
  RenderedSensor sensor;
  for (const SensorKey& key : sensor_keys()) {
    EXPECT_TRUE(names.insert(key.name).second) << key.name;
    EXPECT_TRUE(places.insert(&key.value(sensor)).second) << key.name;
    EXPECT_LT(key.lowest, key.highest) << key.name;
    EXPECT_FALSE(key.meaning.empty()) << key.name;
  }
}

TEST(SensorKeys, AcceptEveryNamedSensor) {
  for (const std::string_view name : kSensorNames) {
    const auto sensor = make_sensor(name);
    ASSERT_TRUE(sensor) << name;
    EXPECT_EQ(sensor->name, name);
    EXPECT_TRUE(validate(*sensor)) << name;
  }
}

TEST(SensorKeys, TakeNumbersWithAndWithoutUnits) {
  RenderedSensor sensor;
  ASSERT_TRUE(set_sensor_value(sensor, "shadow.right=5cm"));
  EXPECT_DOUBLE_EQ(sensor.shadow.right_m, 0.05);
  ASSERT_TRUE(set_sensor_value(sensor, "shadow.right=0.06"));
  EXPECT_DOUBLE_EQ(sensor.shadow.right_m, 0.06);
  ASSERT_TRUE(set_sensor_value(sensor, "shutter.depth=20ms"));
  ASSERT_TRUE(set_sensor_value(sensor, "bias.share=1.5%"));
  ASSERT_TRUE(set_sensor_value(sensor, "disparity.noise=0.08px"));
  ASSERT_TRUE(set_sensor_value(sensor, "returns.grazing_begin=75deg"));
  EXPECT_DOUBLE_EQ(sensor.shutter.depth_s, 0.020);
  EXPECT_DOUBLE_EQ(sensor.bias.share, 0.015);
  EXPECT_DOUBLE_EQ(sensor.disparity.noise_px, 0.08);
  EXPECT_DOUBLE_EQ(sensor.returns.grazing_begin_deg, 75);
}

TEST(SensorKeys, TurnAnEffectOffAndOn) {
  RenderedSensor sensor = *make_sensor("kinect1");
  ASSERT_TRUE(set_sensor_value(sensor, "edges=off"));
  EXPECT_EQ(sensor.edges.dropout, 0);
  EXPECT_EQ(sensor.edges.lateral_px, 0);
  EXPECT_GT(sensor.disparity.noise_px, 0) << "other effects stay";
  ASSERT_TRUE(set_sensor_value(sensor, "edges.lateral=on"));
  EXPECT_EQ(sensor.edges.lateral_px, make_sensor("kinect1")->edges.lateral_px);
  EXPECT_EQ(sensor.edges.dropout, 0);
}

TEST(SensorKeys, OfEveryEffectCanBeTurnedOffUntilNothingIsLeft) {
  for (const std::string_view name : kSensorNames) {
    RenderedSensor sensor = *make_sensor(name);
    for (const SensorKey& key : sensor_keys()) {
      ASSERT_TRUE(set_sensor_value(sensor, std::string(key.name) + "=off")) << key.name;
      EXPECT_EQ(value_of(key, sensor), value_of(key, RenderedSensor{})) << key.name;
    }
    EXPECT_TRUE(validate(sensor));
  }
}

TEST(SensorKeys, SayWhichValueIsWrongAndWhatWasExpected) {
  EXPECT_EQ(error_of("disparity.noise=much"), "disparity.noise: 'much', expected 0 to 5 px, on or off");
  EXPECT_EQ(error_of("disparity.noise=-1"), "disparity.noise: '-1', expected 0 to 5 px, on or off");
  EXPECT_EQ(error_of("disparity.noise=0.1s"), "disparity.noise: '0.1s', expected 0 to 5 px, on or off");
  EXPECT_EQ(error_of("disparity.noise=nan"), "disparity.noise: 'nan', expected 0 to 5 px, on or off");
  EXPECT_EQ(error_of("edges=0.5"), "edges: '0.5', expected on or off for a whole effect");
  EXPECT_EQ(error_of("edges"), "edges: '', expected KEY=VALUE");
  EXPECT_EQ(error_of("disparity.nose=1").substr(0, 40), "disparity.nose: '1', no such key; there ");
}

TEST(SensorKeys, RefuseLimitsInTheWrongOrder) {
  RenderedSensor sensor;
  sensor.range = {.min_m = 3, .max_m = 2};
  ASSERT_FALSE(validate(sensor));
  EXPECT_NE(validate(sensor).error().message.find("range.min: '3', expected less than range.max"), std::string::npos);
  sensor = {};
  sensor.disparity.baseline_m = 0.05;
  EXPECT_FALSE(validate(sensor)) << "a baseline without a focal length";
}

TEST(Sensors, NobodyKnowsAreRefused) {
  const auto sensor = make_sensor("kinect9");
  ASSERT_FALSE(sensor);
  EXPECT_EQ(sensor.error().code, ErrorCode::kConfig);
  EXPECT_NE(sensor.error().message.find("ideal, kinect1, d435, phone_lidar"), std::string::npos);
}

TEST(Sensors, KeepTheirFieldOfViewAtAnySize) {
  const RenderedSensor sensor = *make_sensor("d435");
  EXPECT_EQ(camera_of(sensor, 0, 0).width, 1280);
  EXPECT_EQ(camera_of(sensor, 640, 0).height, 360);
  EXPECT_DOUBLE_EQ(camera_of(sensor, 640, 0).fx, camera_of(sensor, 0, 0).fx / 2);
}

TEST(Sensors, StateTheCameraThatTheyBelieveIn) {
  RenderedSensor sensor;
  sensor.calibration = {.focal_share = 0.01, .centre_x_px = 2, .centre_y_px = -3};
  const CameraIntrinsics real = camera_of(sensor, 320, 240);  // half of the sensor's own size
  const CameraIntrinsics stated = stated_camera(sensor, real);
  EXPECT_DOUBLE_EQ(stated.fx, 1.01 * real.fx);
  EXPECT_DOUBLE_EQ(stated.cx, real.cx + 1);
  EXPECT_DOUBLE_EQ(stated.cy, real.cy - 1.5);
}

}  // namespace
}  // namespace scanknit
