// LiDAR sweeps: their files, and their grids.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>

#include "acquire/lidar/kitti.h"
#include "acquire/lidar/sweep_grid.h"
#include "acquire/lidar/undo_motion.h"
#include "acquire/parse/kitti_poses.h"
#include "tests/acquire/lidar_room.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

using namespace test;

std::vector<std::byte> as_bytes_of(const std::string& text) {
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

Sweep sweep_at(const Pose& T_room_sensor, const LidarModel& model = {}) {
  return {.points_m = sweep_of_room(model, T_room_sensor), .T_world_sensor = T_room_sensor};
}

/// Whether each point's row is its ring.
bool rows_are_rings(const SweepRows& rows, const LidarModel& model) {
  for (std::size_t i = 0; i < rows.row_of_point.size(); ++i) {
    if (rows.row_of_point[i] != i / static_cast<std::size_t>(model.columns)) return false;
  }
  return rows.rows == model.rings;
}

TEST(KittiPoints, CutAtEveryByteAreWholePointsOrAnError) {
  const std::vector<Eigen::Vector3f> points = {{1, 2, 3}, {-4, 5, -6}, {7, 8, 9}};
  const auto bytes = as_bytes_of(kitti_bytes(points));
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const auto read = parse_kitti_points(std::span(bytes).first(size));
    ASSERT_EQ(read.has_value(), size % 16 == 0) << size;
    if (!read) continue;
    ASSERT_EQ(read->size(), size / 16);
    for (std::size_t i = 0; i < read->size(); ++i) EXPECT_EQ((*read)[i], points[i]);
  }
}

TEST(KittiPoints, ThatAreNoReturnAreLeftOut) {
  const auto bytes = as_bytes_of(kitti_bytes({{NAN, 0, 1}, {0, 0, 0}, {1, HUGE_VALF, 1}, {1e30F, 0, 0}, {1, 2, 3}}));
  const auto read = parse_kitti_points(bytes);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 1u);
  EXPECT_EQ(read->front(), Eigen::Vector3f(1, 2, 3));
}

TEST(KittiCalibration, IsTheLineTr) {
  const Pose pose = kitti_camera_of_sensor();
  const auto read = parse_kitti_calibration("P0: 1 2 3\nTr: " + twelve_numbers(pose) + "\n");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE(read->isApprox(pose, 1e-6));
  EXPECT_FALSE(parse_kitti_calibration("P0: 1 2 3\n"));
  EXPECT_FALSE(parse_kitti_calibration("Tr: 1 0 0 0 0 1 0 0 0 0 1\n")) << "eleven numbers";
  EXPECT_FALSE(parse_kitti_calibration("Tr: 2 0 0 0 0 1 0 0 0 0 1 0\n")) << "not rigid";
}

TEST(KittiPoses, AreErrorsWhereALineIsNone) {
  const auto poses = parse_kitti_poses("1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 nan 0 1 0 0 0 0 1 0\n1 2\n");
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_TRUE(poses[0]);
  EXPECT_FALSE(poses[1]);
  EXPECT_NE(poses[2].error().message.find("line 3"), std::string::npos);
}

TEST(SweepRows, AreTheLasersByTheOrderOfThePoints) {
  const LidarModel model;
  const SweepRows rows = find_rows(sweep_at(sensor_at(0.3), model));
  EXPECT_EQ(rows.kind, SweepRows::Kind::kOrder);
  EXPECT_TRUE(rows_are_rings(rows, model));
}

TEST(SweepRows, AreTheLasersThoughPointsCrossTheSeam) {
  const LidarModel model;
  Sweep sweep = sweep_at(sensor_at(0.3), model);
  const auto columns = static_cast<std::size_t>(model.columns);
  ASSERT_EQ(sweep.points_m.size() % columns, 0u);
  for (std::size_t i = columns; i < sweep.points_m.size(); i += columns) {
    std::swap(sweep.points_m[i - 1], sweep.points_m[i]);  // a turn's last point after the next one's first
  }
  const SweepRows rows = find_rows(sweep);
  EXPECT_EQ(rows.kind, SweepRows::Kind::kOrder);
  EXPECT_EQ(rows.rows, model.rings);
}

TEST(SweepRows, AreTheRingsWhereTheRecordingNamesThem) {
  const LidarModel model;
  Sweep sweep = sweep_at(sensor_at(0.3), model);
  for (std::size_t i = 0; i < sweep.points_m.size(); ++i) {
    const auto ring = i / static_cast<std::size_t>(model.columns);
    sweep.rings.push_back(static_cast<std::uint16_t>(model.rings - 1 - static_cast<int>(ring)));  // from below
  }
  const SweepRows rows = find_rows(sweep);
  EXPECT_EQ(rows.kind, SweepRows::Kind::kRings);
  EXPECT_TRUE(rows_are_rings(rows, model)) << "row 0 is the highest";
}

TEST(SweepRows, AreElevationsWithGapsBetweenThemInAnyOrder) {
  const LidarModel model;
  Sweep sweep = sweep_at(sensor_at(0.3), model);
  std::vector<Eigen::Vector3f> by_column;  // as a scanner fires: all lasers, then the next azimuth
  for (int column = 0; column < model.columns; ++column) {
    for (int ring = 0; ring < model.rings; ++ring) {
      by_column.push_back(sweep.points_m[static_cast<std::size_t>(ring * model.columns + column)]);
    }
  }
  sweep.points_m = by_column;
  const SweepRows rows = find_rows(sweep);
  EXPECT_EQ(rows.kind, SweepRows::Kind::kElevations);
  ASSERT_EQ(rows.rows, model.rings);
  for (std::size_t i = 0; i < by_column.size(); ++i) {
    ASSERT_EQ(rows.row_of_point[i], i % static_cast<std::size_t>(model.rings));
  }
}

TEST(SweepRows, AreUniformWhereThereAreNoGaps) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> along(-1, 1);
  Sweep sweep;
  while (sweep.points_m.size() < 20'000) {
    const Eigen::Vector3f p(along(random), along(random), 0.3F * along(random));
    if (p.norm() > 0.5F) sweep.points_m.push_back(p);
  }
  const SweepRows rows = find_rows(sweep);
  EXPECT_EQ(rows.kind, SweepRows::Kind::kUniform);
  EXPECT_GT(rows.rows, 50);
  EXPECT_LE(rows.rows, 451);
}

TEST(SweepGrid, HoldsNearlyAllPointsWithoutHoles) {
  const RangeScan grid = grid_of(sweep_at(sensor_at(0.5)), {0.1, 100});
  ASSERT_EQ(grid.points_m.height(), 32);
  std::size_t returns = 0;
  for (const Eigen::Vector3f& p : grid.points_m.pixels()) returns += has_return(p) ? 1 : 0;
  EXPECT_EQ(returns, grid.points_m.size()) << "no cell is empty";
  EXPECT_GT(grid.points_m.width(), 600) << "of 900 azimuths";
  for (int y = 0; y < grid.points_m.height(); ++y) {
    EXPECT_EQ(grid.points_m.at(0, y), grid.points_m.at(grid.points_m.width() - 1, y)) << "closed round the sensor";
  }
}

TEST(SweepGrid, KeepsTheNearestReturnWithinTheRange) {
  Sweep sweep = sweep_at(Pose::Identity());
  const std::size_t points = sweep.points_m.size();
  for (std::size_t i = 0; i < points; ++i) sweep.points_m.push_back(0.9F * sweep.points_m[i]);
  const RangeScan near = grid_of(sweep, {0.1, 100});
  for (const Eigen::Vector3f& p : near.points_m.pixels()) {
    ASSERT_TRUE(has_return(p));
    ASSERT_GT(off_walls_m(p.cast<double>()), 0.1) << "the nearer return";
  }
  const RangeScan bounded = grid_of(sweep, {2, 5});
  for (const Eigen::Vector3f& p : bounded.points_m.pixels()) {
    ASSERT_TRUE(!has_return(p) || (p.norm() >= 2 && p.norm() <= 5)) << p.transpose();
  }
}

TEST(SweepGrid, OfOddSweepsIsSound) {
  EXPECT_TRUE(grid_of({}, {}).points_m.empty());
  EXPECT_EQ(grid_of({.points_m = {{1, 0, 0}}}, {}).points_m.height(), 1);
  EXPECT_EQ(grid_of({.points_m = {{0, 0, 1}, {0, 0, -1}}}, {}).points_m.height(), 2) << "straight up and down";
  Sweep wrong{.points_m = {{1, 0, 0}, {2, 0, 0}}, .rings = {65535, 0}};
  EXPECT_GE(grid_of(wrong, {}).points_m.height(), 1) << "rings that cannot be";
}

/// A turn of a tenth of a second; column after column, each at its own time and place.
Sweep sweep_on_the_way(const SensorPath& path, const LidarModel& model) {
  Sweep sweep{.timestamp_ns = 1'000'000'000, .T_world_sensor = *path(1'000'000'000)};
  for (int column = 0; column < model.columns; ++column) {
    const std::int64_t offset_ns = 100'000'000LL * column / model.columns;
    const Pose T_room_sensor = *path(1'000'000'000 + offset_ns);
    for (int ring = 0; ring < model.rings; ++ring) {
      const Eigen::Vector3d ray = model.direction(ring, column);
      const double range_m = ray_in_room_m(T_room_sensor.translation(), T_room_sensor.linear() * ray);
      sweep.points_m.push_back((ray * range_m).cast<float>());
      sweep.offsets_ns.push_back(offset_ns);
    }
  }
  return sweep;
}

double farthest_off_walls_m(const Sweep& sweep) {
  double farthest = 0;
  for (const auto& p : sweep.points_m) {
    farthest = std::max(farthest, off_walls_m(sweep.T_world_sensor * p.cast<double>()));
  }
  return farthest;
}

TEST(UndoMotion, PutsThePointsOfAMovingScannerOnTheWalls) {
  // Two metres and half a radian a second: a quick walker who turns.
  const SensorPath path = [](std::int64_t time_ns) -> std::optional<Pose> {
    const double since_s = static_cast<double>(time_ns - 1'000'000'000) * 1e-9;
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d(2 * since_s, 0.3 * since_s, 0);
    pose.linear() = Eigen::AngleAxisd(0.5 * since_s, Eigen::Vector3d(0.1, 0, 1).normalized()).matrix();
    return pose;
  };
  Sweep sweep = sweep_on_the_way(path, {});
  EXPECT_GT(farthest_off_walls_m(sweep), 0.05) << "the motion is there";
  ASSERT_TRUE(undo_motion(path, sweep));
  EXPECT_LT(farthest_off_walls_m(sweep), 1e-4);
  EXPECT_TRUE(sweep.offsets_ns.empty());
}

TEST(UndoMotion, LeavesASweepAloneWhosePathIsNotKnown) {
  const auto start_only = [](std::int64_t time_ns) {
    return time_ns < 1'050'000'000 ? std::optional(sensor_at(0)) : std::nullopt;
  };
  Sweep sweep = sweep_on_the_way([](std::int64_t) { return std::optional(sensor_at(0)); }, {});
  const auto before = sweep.points_m;
  EXPECT_FALSE(undo_motion(start_only, sweep));
  EXPECT_EQ(sweep.points_m, before);
  sweep.offsets_ns.front() = std::numeric_limits<std::int64_t>::max();
  EXPECT_FALSE(undo_motion(start_only, sweep)) << "a sweep of three hundred years";
  sweep.offsets_ns.pop_back();
  EXPECT_FALSE(undo_motion(start_only, sweep)) << "a point without a time";
  sweep.timestamp_ns.reset();
  EXPECT_TRUE(undo_motion(start_only, sweep)) << "without a clock all is taken as measured at once";
  EXPECT_EQ(sweep.points_m, before);
}

TEST(KittiSweeps, AreOpenedByTheirFolder) {
  const test::TemporaryFolder folder;
  write_kitti_room(folder.path() / "seq", 3);
  EXPECT_TRUE(is_sweep_recording(folder.path() / "seq", {}));
  EXPECT_FALSE(is_sweep_recording(folder.path() / "nothing", {}));
  const auto sweeps = open_sweeps(folder.path() / "seq", {});
  ASSERT_TRUE(sweeps) << sweeps.error().text();
  EXPECT_EQ((*sweeps)->info().sweeps, 3u);
  EXPECT_EQ((*sweeps)->info().sweeps_with_pose, 3u);
  EXPECT_NEAR(*(*sweeps)->info().duration_s, 0.2, 1e-9);
  const auto event = (*sweeps)->read(2);
  const auto* sweep = std::get_if<Sweep>(&event);
  ASSERT_NE(sweep, nullptr);
  EXPECT_TRUE(sweep->T_world_sensor.isApprox(kitti_camera_of_sensor() * sensor_at(1), 1e-6))
      << "the world is the camera's frame; the pose is the sensor's";
}

TEST(KittiSweeps, AreFoundInTheBenchmarksOwnFolders) {
  const test::TemporaryFolder folder;
  const auto root = folder.path(), sequences = root / "sequences";
  write_kitti_room(sequences / "00", 1);
  for (const auto& path : {root, sequences, sequences / "00", sequences / "00" / "velodyne"}) {
    const auto sweeps = open_sweeps(path, {});
    ASSERT_TRUE(sweeps) << path << ": " << sweeps.error().text();
    EXPECT_EQ((*sweeps)->info().folder, sequences / "00");
  }
  write_kitti_room(sequences / "01", 1);
  const auto sweeps = open_sweeps(root, {});
  ASSERT_FALSE(sweeps);
  EXPECT_NE(sweeps.error().text().find("holds 2 sequences of LiDAR sweeps; name one of them"), std::string::npos);
}

TEST(KittiSweeps, RefuseACamerasCalibration) {
  const test::TemporaryFolder folder;
  write_kitti_room(folder.path() / "seq", 1);
  AcquireConfig config;
  config.camera = std::make_shared<const ScannerCamera>(ScannerCamera{.file = "CAMERA.yaml"});
  const auto sweeps = open_sweeps(folder.path() / "seq", config);
  ASSERT_FALSE(sweeps);
  EXPECT_EQ(sweeps.error().code, ErrorCode::kConfig);
  EXPECT_EQ(sweeps.error().text(), "CAMERA.yaml: acquire.camera: LiDAR sweeps are seen by no camera; leave it at auto");
}

}  // namespace
}  // namespace scanknit
