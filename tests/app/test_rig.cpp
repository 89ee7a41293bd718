// `calibrate rig` and `run --rig` as a user calls them, on rendered recordings of four cameras.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "core/rotation.h"
#include "export/mesh/read_mesh.h"
#include "synth/scene/board_scene.h"
#include "synth/sensor/sensor_keys.h"
#include "synth/write_recording.h"
#include "tests/app/suite_folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A scene with another path.
class OtherPath final : public SyntheticScene {
 public:
  OtherPath(const SyntheticScene& scene, CameraPath path)
      : SyntheticScene(scene.name(), std::move(path), scene.default_frames()), scene_(scene) {}
  [[nodiscard]] std::optional<double> intersect(const Ray& ray, double max_t_m) const override {
    return scene_.intersect(ray, max_t_m);
  }
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const override { return scene_.distance(p); }
  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p) const override { return scene_.nearest(p); }
  [[nodiscard]] Eigen::Vector3d colour(const SurfacePoint& point) const override { return scene_.colour(point); }
  [[nodiscard]] SurfaceMaterial material(const SurfacePoint& point) const override { return scene_.material(point); }
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return scene_.bounds(); }

 private:
  const SyntheticScene& scene_;
};

Pose rig_pose(const Eigen::Vector3d& position, double right_degrees, double up_degrees, double roll_degrees) {
  Pose pose(Eigen::Translation3d(position) * Eigen::AngleAxisd(right_degrees * kDegree, Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(up_degrees * kDegree, Eigen::Vector3d::UnitX()) *
            Eigen::AngleAxisd(roll_degrees * kDegree, Eigen::Vector3d::UnitZ()));
  return pose;
}

/// T_rig_camera: all look at one place, 0.65 m before the first.
const std::array<Pose, 4> kCameras = {Pose::Identity(), rig_pose({0.28, 0.02, 0.05}, -24, 1, 2),
                                      rig_pose({-0.26, 0.03, 0.03}, 22, -3, -4),
                                      rig_pose({0.02, -0.27, 0.04}, 1, -24, 5)};
/// The moment of each recording's first picture, by the rig's clock.
constexpr std::array<double, 4> kBegin_s = {0, 0.37, 0.125, 0.95};
constexpr double kRate_hz = 8, kSeconds = 14;

/// A rig before the board, which stands still here and moves in the cameras' eyes.
Pose T_world_rig(double time_s) {
  const auto wave = [&](double turns, double phase) {
    return std::sin(2 * std::numbers::pi * turns * time_s / kSeconds + phase);
  };
  const Pose T_rig_board = rig_pose({0.07 * wave(2, 0), 0.05 * wave(1.5, 1), 0.65 + 0.1 * wave(1.2, 2)},
                                    20 * wave(1.7, 0.5), 20 * wave(1.3, 2.5), 20 * wave(0.8, 0));
  return Eigen::Translation3d(0, -1.2, 0) * T_rig_board.inverse();
}

class RigOfFour : public SuiteFolder {
 protected:
  static void SetUpTestSuite() {
    SuiteFolder::SetUpTestSuite();
    const auto board = board_scene();
    ASSERT_TRUE(board);
    for (std::size_t i = 0; i < kCameras.size(); ++i) {
      write(OtherPath(**board, [i](double s) { return T_world_rig(kBegin_s[i] + kSeconds * s) * kCameras[i]; }),
            board_of(i), static_cast<int>(kRate_hz * kSeconds), "ideal");
    }
    std::ofstream(target()) << "{type: aprilgrid, columns: 6, rows: 4, size: 40mm}";
    const auto sphere = make_scene("sphere");
    ASSERT_TRUE(sphere);
    for (std::size_t i = 0; i < kCameras.size(); ++i) {
      write(OtherPath(**sphere, [i](double) { return T_sphere_rig() * kCameras[i]; }), object_of(i), 4, "d435");
    }
  }

  static void write(const SyntheticScene& scene, const std::string& folder, int frames, const char* sensor) {
    SynthConfig config;
    config.frames = frames;
    config.truth_points = 1000;
    config.min_views = 1;
    config.sensor = *make_sensor(sensor);
    for (const char* value : {"colour.noise=0.01", "time.rate=8"}) {
      ASSERT_TRUE(set_sensor_value(*config.sensor, value));
    }
    config.intrinsics = camera_of(*make_sensor("ideal"), 640, 480);  // one camera for board and object
    const auto written = write_synthetic_recording(scene, config, folder);
    ASSERT_TRUE(written) << written.error().text();
  }

  /// The sphere is round the world's origin.
  static Pose T_sphere_rig() { return Pose(Eigen::Translation3d(0, 0, -0.65)); }
  static std::string board_of(std::size_t camera) { return place("board" + std::to_string(camera)); }
  static std::string object_of(std::size_t camera) { return place("object" + std::to_string(camera)); }
  static std::string target() { return place("target.yaml"); }

  static Outcome calibrate(const std::vector<std::string>& recordings, const std::string& target,
                           const std::string& output, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"calibrate", "rig"};
    arguments.insert(arguments.end(), recordings.begin(), recordings.end());
    arguments.insert(arguments.end(), {"--target", target, "-o", place(output), "--json", "--quiet"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  static std::vector<std::string> all_of(std::string (*recording_of)(std::size_t)) {
    return {recording_of(0), recording_of(1), recording_of(2), recording_of(3)};
  }
  static Outcome run(const std::vector<std::string>& recordings, const std::string& rig, const std::string& output,
                     const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"run"};
    arguments.insert(arguments.end(), recordings.begin(), recordings.end());
    arguments.insert(arguments.end(), {"--rig", rig, "-o", place(output), "--set", "fusion.voxel_size=4mm"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }

  /// The camera with which all pictures are rendered.
  static std::string true_camera() {
    std::ofstream(place("camera.yaml"))
        << "colour: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5, distortion: [0, 0, 0, 0, 0]}\n"
           "depth: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5, distortion: [0, 0, 0, 0, 0]}\n";
    return place("camera.yaml");
  }

  static std::string true_rig() {
    const std::string camera = true_camera();
    std::ofstream file(place("truth.yaml"));
    file.precision(17);
    file << "cameras:\n";
    for (const Pose& pose : kCameras) {
      const Eigen::Quaterniond q(pose.linear());
      const Eigen::Vector3d& t = pose.translation();
      file << "  - T_rig_camera: [" << t.x() << ", " << t.y() << ", " << t.z() << ", " << q.x() << ", " << q.y() << ", "
           << q.z() << ", " << q.w() << "]\n    camera: \"" << camera << "\"\n";
    }
    return place("truth.yaml");
  }

  /// The mean distance of the mesh's vertices from the sphere.
  static double error_m(const std::string& output) {
    const auto sphere = make_scene("sphere");
    const auto mesh = read_mesh(fs::path(place(output)) / "model.ply");
    EXPECT_TRUE(mesh);
    double sum = 0;
    for (const Eigen::Vector3f& vertex : mesh->positions_m) {
      sum += (*sphere)->surface_distance(T_sphere_rig() * vertex.cast<double>());
    }
    EXPECT_GT(mesh->positions_m.size(), 1000u);
    return sum / static_cast<double>(mesh->positions_m.size());
  }
};

TEST_F(RigOfFour, IsFoundByABoardAndFusesAsWellAsATrueRig) {
  const Outcome outcome = calibrate(all_of(board_of), target(), "rig.yaml");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  for (std::size_t i = 1; i < kCameras.size(); ++i) {
    const Json& camera = json["cameras"][i];
    const auto numbers = camera["T_rig_camera"].get<std::array<double, 7>>();
    const Eigen::Vector3d position(numbers[0], numbers[1], numbers[2]);
    const Eigen::Quaterniond turn(numbers[6], numbers[3], numbers[4], numbers[5]);
    EXPECT_LT((position - kCameras[i].translation()).norm(), 0.0005) << i << outcome.out;
    EXPECT_LT(turn.angularDistance(Eigen::Quaterniond(kCameras[i].linear())), 0.05 * kDegree) << i;
    EXPECT_NEAR(camera["clock_offset_ms"].get<double>(), 1000 * kBegin_s[i], 1) << i;
    EXPECT_GE(camera["shared_moments"].get<int>(), 30) << i;
  }
  ASSERT_EQ(run(all_of(object_of), true_rig(), "true").exit_code, 0);
  const Outcome fused = run(all_of(object_of), place("rig.yaml"), "found");
  ASSERT_EQ(fused.exit_code, 0) << fused.err;
  EXPECT_EQ(report("found")["frames"]["fused"], 16);
  EXPECT_LT(error_m("found"), 1.1 * error_m("true"));
  RecordProperty("found_mm", std::to_string(1000 * error_m("found")));
  RecordProperty("true_mm", std::to_string(1000 * error_m("true")));
}

TEST_F(RigOfFour, TakesCalibratedCamerasAndAgreesWithThem) {
  std::vector<std::string> cameras;
  for (int i = 0; i < 2; ++i) {
    cameras.insert(cameras.end(), {"--camera", true_camera()});
  }
  const Outcome outcome = calibrate({board_of(0), board_of(1)}, target(), "given.yaml", cameras);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(read_text(place("given.yaml")).find("camera: \"" + place("camera.yaml") + "\""), std::string::npos);
  EXPECT_EQ(run({object_of(0), object_of(1)}, place("given.yaml"), "given").exit_code, 0);
  cameras.resize(2);
  EXPECT_EQ(calibrate({board_of(0), board_of(1)}, target(), "no.yaml", cameras).exit_code, 2);
}

TEST_F(RigOfFour, SaysWhatIsWrongWithTheRecordings) {
  std::ofstream(place("other.yaml")) << "{type: aprilgrid, columns: 4, rows: 6, size: 40mm}";
  const Outcome other = calibrate({board_of(0), board_of(1)}, place("other.yaml"), "no.yaml");
  EXPECT_EQ(other.exit_code, 4);
  EXPECT_NE(other.err.find("another board"), std::string::npos) << other.err;
  const Outcome unseen = calibrate({board_of(0), object_of(1)}, target(), "no.yaml");
  EXPECT_EQ(unseen.exit_code, 4);
  EXPECT_NE(unseen.err.find(object_of(1)), std::string::npos) << unseen.err;
  EXPECT_EQ(calibrate({board_of(0), board_of(1) + "/color"}, target(), "no.yaml").exit_code, 4);
  EXPECT_EQ(calibrate({board_of(0)}, target(), "no.yaml").exit_code, 2) << "one recording is no rig";
  EXPECT_FALSE(fs::exists(place("no.yaml")));
}

TEST_F(RigOfFour, ARecordingThatIsBrokenDoesNotEndTheOthers) {
  const std::string broken = place("broken.mcap");
  std::ofstream(broken) << "no recording";
  const Outcome fused = run({object_of(0), broken, object_of(2), object_of(3)}, true_rig(), "three");
  ASSERT_EQ(fused.exit_code, 0) << fused.err;
  EXPECT_NE(fused.err.find("a camera of the rig is left out"), std::string::npos) << fused.err;
  EXPECT_NE(fused.err.find(broken), std::string::npos) << fused.err;
  EXPECT_EQ(report("three")["frames"]["fused"], 12);
  EXPECT_LT(error_m("three"), 0.001);
  EXPECT_EQ(run({broken, broken, broken, broken}, true_rig(), "none").exit_code, 4);

  const fs::path picture = fs::path(object_of(1)) / "depth/000002.png";
  const std::string bytes = read_text(picture);
  std::ofstream(picture) << "torn";
  const Outcome torn = run(all_of(object_of), true_rig(), "torn");
  std::ofstream(picture) << bytes;
  ASSERT_EQ(torn.exit_code, 0) << torn.err;
  EXPECT_EQ(report("torn")["frames"]["fused"], 15);
  EXPECT_EQ(report("torn")["frames"]["dropped_by_reason"]["unreadable"], 1);
}

TEST_F(RigOfFour, IsRefusedWhereItDoesNotFit) {
  const auto refused = [&](const Outcome& outcome, int exit_code, const std::string& part) {
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
  };
  refused(run({object_of(0), object_of(1)}, true_rig(), "no"), 2, "has 4 cameras, and the command line 2 recordings");
  refused(scanknit_command({"run", object_of(0), object_of(1), "-o", place("no")}), 2, "give --rig");
  refused(run(all_of(object_of), true_rig(), "no", {"--poses", "track"}), 3, "known");
  refused(run(all_of(object_of), true_rig(), "no", {"--set", "turntable.enabled=true"}), 2, "turntable");
  struct Fault {
    std::string text, part;
  };
  for (const Fault& fault : std::vector<Fault>{
           {"cameras: [{T_rig_camera: [0, 0, 0, 0, 0, 0, 1]}]", "at least two"},
           {"cameras: [{clock_offset_ms: 1}, {T_rig_camera: [0, 0, 0, 0, 0, 0, 1]}]", "'T_rig_camera' is missing"},
           {"cameras: [{T_rig_camera: [0, 0, 0, 0, 0, 0, 2]}, {}]", "quaternion of length 1"},
           {"cameras: [{T_rig_camera: [0, 0, 0, 0, 0, 0, 1], typo: 1}, {}]", "unknown key 'typo'"},
           {"cameras: [{T_rig_camera: [0, 0, 0, 0, 0, 0, 1], clock_offset_ms: x}, {}]", "number of milliseconds"},
           {"cameras: [{T_rig_camera: [0, 0, 0, 0, 0, 0, 1], camera: {colour: 1}}, {}]", "colour: expected a map"},
           {"- 1", "cameras:"},
           {"[", ""}}) {
    std::ofstream(place("bad.yaml")) << fault.text;
    refused(run({object_of(0), object_of(1)}, place("bad.yaml"), "no"), 3, fault.part);
  }
  EXPECT_EQ(run({object_of(0), object_of(1)}, place("absent.yaml"), "no").exit_code, 4);
}

}  // namespace
}  // namespace scanknit
