// `scanknit align` as a user runs it.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "export/mesh/read_mesh.h"
#include "fusion/align/point_grid.h"
#include "tests/app/program.h"
#include "tests/app/range_grids.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Json report_of(const fs::path& folder) {
  return Json::parse(read_text(folder / "report.json"), nullptr, false);
}

Pose turned(double degrees, const Eigen::Vector3d& moved) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(degrees * 0.017453292519943295, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = moved;
  return pose;
}

Pose pose_of(const Json& rows) {
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      pose.matrix()(row, column) = rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)].get<double>();
  }
  return pose;
}

/// Two grids of the hills that overlap by 60 %, one of them turned by 50 degrees and moved.
class AlignHills : public ::testing::Test {
 protected:
  AlignHills() {
    write_hills(folder_ / "a.ply", 0, Pose::Identity());
    write_hills(folder_ / "b.ply", 0.05, T_b_world_);
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] Outcome align(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "align");
    return scanknit_command(arguments);
  }
  /// Lists a at `T_world_a`, and b.
  void write_conf(const std::string& name, const Pose& T_world_a, const Pose& T_world_b,
                  const std::string& more = "") const {
    std::ofstream file(path(name));
    file.precision(17);
    for (const auto& [scan, pose] : {std::pair("a.ply", T_world_a), std::pair("b.ply", T_world_b)}) {
      const Eigen::Quaterniond q(pose.linear().transpose());  // the file's quaternion turns the other way
      file << "bmesh " << scan << " " << pose.translation().transpose() << " " << q.coeffs().transpose() << "\n";
    }
    file << more;
  }
  [[nodiscard]] std::string warnings_of(const std::string& folder) const {
    return report_of(folder_ / folder)["warnings"].dump();
  }
  /// Where b is found, against the truth: at its middle, metres.
  [[nodiscard]] double error_m(const Json& report) const {
    const Pose T_a_b = pose_of(report["alignment"]["scans"][1]["T_world_scan"]);
    const Eigen::Vector3d middle(0.11, 0.06, 0);
    return (T_a_b * (T_b_world_ * middle) - middle).norm();
  }

  TempFolder folder_;
  Pose T_b_world_ = turned(50, {0.3, -0.1, 0.05});
};

TEST_F(AlignHills, TwoGridsFromAnywhereBecomeOneMesh) {
  const Outcome outcome = align({path("a.ply"), path("b.ply"), "-o", path("out")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json report = report_of(folder_ / "out");
  EXPECT_LT(error_m(report), 0.0002);
  EXPECT_EQ(report["alignment"]["pairs"][0]["verdict"], "good");
  EXPECT_EQ(report["mesh"]["components"], 1);
  EXPECT_EQ(report["mesh"]["non_manifold_edges"], 0);
  EXPECT_NEAR(report["mesh"]["bounds_m"][1][0].get<double>(), 0.17, 0.002);
  EXPECT_EQ(report["config"]["fusion"]["voxel_size"], 0.001) << "the spacing of the points";
  for (const char* name : {"model.glb", "model.ply", "preview.png", "trajectory.txt", "pair_1_2.png"}) {
    EXPECT_TRUE(fs::is_regular_file(folder_ / "out" / name)) << name;
  }
  const auto mesh = read_mesh(folder_ / "out" / "model.ply");
  ASSERT_TRUE(mesh);
  for (const Eigen::Vector3f& p : mesh->positions_m) {
    EXPECT_NEAR(double{p.z()}, hills_m(double{p.x()}, double{p.y()}), 0.0005);
  }
  EXPECT_NE(outcome.out.find("good"), std::string::npos) << outcome.out;
}

TEST_F(AlignHills, AreFusedWithAnyVoxelSizeThatIsGiven) {
  for (const char* given : {"0.0123", "0.004"}) {  // 4 mm is what configs/default.yaml has
    const Outcome outcome =
        align({path("a.ply"), path("b.ply"), "-o", path("out"), "--set", std::string("fusion.voxel_size=") + given,
               "--set", "extract.min_component_triangles=0"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(report_of(folder_ / "out")["config"]["fusion"]["voxel_size"], std::stod(given));
    EXPECT_EQ(outcome.err.find("the spacing of the points"), std::string::npos) << outcome.err;
  }
}

TEST_F(AlignHills, GiveTheSameBytesForAnyNumberOfThreads) {
  std::string first;
  for (const char* threads : {"1", "2", "8"}) {
    const Outcome outcome = align({path("a.ply"), path("b.ply"), "-o", path("m.ply"), "--threads", threads});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string bytes = read_text(path("m.ply"));
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first) << threads << " threads";
  }
  EXPECT_GT(first.size(), 100'000u);
}

TEST_F(AlignHills, WhatDoesNotOverlapEndsWithCode6AndWords) {
  write_hills(path("far.ply"), 0.6, turned(20, {0, 0, 0}));
  const Outcome outcome = align({path("a.ply"), path("b.ply"), path("far.ply"), "-o", path("out")});
  EXPECT_EQ(outcome.exit_code, 6) << outcome.out;
  EXPECT_NE(outcome.err.find("no place was found for 3 (far.ply)"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("initial poses or markers"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(folder_ / "out" / "model.glb"));
  const Json report = report_of(folder_ / "out");
  EXPECT_EQ(report["alignment"]["scans"][1]["is_placed"], true);
  EXPECT_EQ(report["alignment"]["scans"][2]["is_placed"], false);
  EXPECT_TRUE(report["alignment"]["scans"][2]["T_world_scan"].is_null());
}

TEST_F(AlignHills, AConfGivesPosesAndAnAbsentScanIsWarnedOf) {
  // The file's quaternion turns the other way.
  const Pose T_world_b = T_b_world_.inverse();
  const Eigen::Quaterniond q(T_world_b.linear().transpose());
  const Eigen::Vector3d t = T_world_b.translation();
  std::ofstream(path("two.conf"))
      << "camera 0 0 0 0 0 0 1\nbmesh a.ply 0 0 0 0 0 0 1\nbmesh gone.ply 0 0 0 0 0 0 1\nbmesh b.ply " << t.x() << " "
      << t.y() << " " << t.z() << " " << q.x() << " " << q.y() << " " << q.z() << " " << q.w() << "\n";
  const Outcome outcome = align({path("two.conf"), "-o", path("out"), "--points", path("all.pcd")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("gone.ply is named, but is not there"), std::string::npos) << outcome.err;
  const Json report = report_of(folder_ / "out");
  EXPECT_LT(error_m(report), 1e-5);
  EXPECT_EQ(report["alignment"]["pairs"][0]["start"], "given");
  EXPECT_EQ(report["warnings"].size(), 1u);
  EXPECT_NE(read_text(path("all.pcd")).find("FIELDS x y z normal_x normal_y normal_z\n"), std::string::npos);
}

TEST_F(AlignHills, MarkersAndInitialPosesAreABeginning) {
  std::ofstream markers(path("markers.txt"));
  for (const auto& [name, p] :
       {std::pair("cross", Eigen::Vector3d(0.06, 0.01, 0)), std::pair("dot", Eigen::Vector3d(0.11, 0.1, 0)),
        std::pair("ring", Eigen::Vector3d(0.07, 0.08, 0.01))}) {
    const Eigen::Vector3d in_b = T_b_world_ * p + Eigen::Vector3d(0.001, 0, -0.001);
    markers << "1 " << name << " " << p.transpose() << "\nb.ply " << name << " " << in_b.transpose() << "\n";
  }
  markers.close();
  const Outcome by_markers = align({path("a.ply"), path("b.ply"), "-o", path("out"), "--markers", path("markers.txt")});
  ASSERT_EQ(by_markers.exit_code, 0) << by_markers.err;
  const Json report = report_of(folder_ / "out");
  EXPECT_EQ(report["alignment"]["pairs"][0]["start"], "prior");
  EXPECT_LT(error_m(report), 0.0002);
  const Outcome by_poses = align(
      {path("a.ply"), path("b.ply"), "-o", path("again"), "--initial", (folder_ / "out" / "trajectory.txt").string()});
  ASSERT_EQ(by_poses.exit_code, 0) << by_poses.err;
  EXPECT_EQ(report_of(folder_ / "again")["alignment"]["pairs"][0]["start"], "prior");
  EXPECT_LT(error_m(report_of(folder_ / "again")), 0.0002);
}

TEST_F(AlignHills, GivenPosesThatContradictWhatWasSeenAreWarnedOf) {
  // Three centimetres above the other: in the way of all that was seen.
  write_conf("wrong.conf", Pose::Identity(), Eigen::Translation3d(0, 0, 0.03) * T_b_world_.inverse());
  const Outcome outcome = align({path("wrong.conf"), "-o", path("out")});
  EXPECT_EQ(outcome.exit_code, 0) << "poses are taken as they are: " << outcome.err;
  for (const char* words : {"1 (a.ply) and 2 (b.ply) contradict what was seen",
                            "no other scan confirms the given pose of 2", "refining corrects poses"}) {
    EXPECT_NE(outcome.err.find(words), std::string::npos) << words << outcome.err;
    EXPECT_NE(warnings_of("out").find(words), std::string::npos) << words;
  }
  write_conf("right.conf", Pose::Identity(), T_b_world_.inverse());
  ASSERT_EQ(align({path("right.conf"), "-o", path("right")}).exit_code, 0);
  EXPECT_EQ(warnings_of("right"), "[]");
}

TEST_F(AlignHills, AMeshLineOfAConfIsWarnedOf) {
  write_conf("old.conf", Pose::Identity(), T_b_world_.inverse(), "mesh a.ply\n");
  const Outcome outcome = align({path("old.conf"), "-o", path("out")});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("old.conf:3: a line 'mesh' is not read"), std::string::npos) << outcome.err;
}

TEST_F(AlignHills, PosesFarFromTheOriginAreMovedNearIt) {
  const Eigen::Translation3d far(500'020, 4'000'000, 100);
  write_conf("map.conf", far * Pose::Identity(), far * T_b_world_.inverse());
  const Outcome outcome = align({path("map.conf"), "-o", path("out")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(warnings_of("out").find("add 500000 4000000 100 m"), std::string::npos) << warnings_of("out");
  const Json report = report_of(folder_ / "out");
  EXPECT_NEAR(report["mesh"]["bounds_m"][0][0].get<double>(), 20, 0.01);
  EXPECT_EQ(report["mesh"]["components"], 1);
  const std::string poses = read_text(folder_ / "out" / "trajectory.txt");
  EXPECT_NE(poses.find("less 500000 4000000 100 m\n1 20 0 0 "), std::string::npos) << poses;
}

TEST_F(AlignHills, WarnsOfUselessOrContradictoryMarkers) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "no marker has the same name"},
      {"1 a 0 0 0\n2 b 0 0 0\n", "no marker has the same name"},
      {"1 a 0 0 0\n1 b 1 0 0\n2 a 0 0 0\n2 b 1 0 0\n", "the scans have 2 markers in common, and at least 3 are needed"},
      {"1 a 0 0 0\n1 b 1 0 0\n1 c 2 0 0\n2 a 0 0 0\n2 b 1 0 0\n2 c 2 0 0\n", "they lie on a line"},
      {"1 a 0 0 0\n1 b 0.1 0 0\n1 c 0 0.2 0\n2 a 0 0 0\n2 b 0.1 0 0\n2 c 0 0.3 0\n", "mm remain"},
      {"1 a 0 0 0\n1 a 1 0 0\n", "marker a of scan 1 is there already"}};
  for (const auto& [text, words] : cases) {
    std::ofstream(path("markers.txt")) << text;
    const Outcome outcome = align({path("a.ply"), path("b.ply"), "-o", path("out"), "--markers", path("markers.txt")});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(warnings_of("out").find(words), std::string::npos) << words << " in " << warnings_of("out");
  }
}

TEST_F(AlignHills, WarnsOfUselessOrContradictoryInitialPoses) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "it has poses of 0 scans"},
      {"1 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n", "initial.txt:2: scan 1 (a.ply) has a pose already"},
      {"1 0 0 0 0 0 0 1\n2 9 9 9 0 0 0 1\n", "mm from the pose at which the scans fit"}};
  for (const auto& [text, words] : cases) {
    std::ofstream(path("initial.txt")) << text;
    const Outcome outcome = align({path("a.ply"), path("b.ply"), "-o", path("out"), "--initial", path("initial.txt")});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(warnings_of("out").find(words), std::string::npos) << words << " in " << warnings_of("out");
  }
}

TEST_F(AlignHills, MillimetresAreHintedAt) {
  Pose millimetres = Pose::Identity();
  millimetres.linear() *= 1000;
  write_hills(path("mm.ply"), 0, millimetres);
  const Outcome outcome = align({path("mm.ply"), path("b.ply"), "-o", path("out")});
  EXPECT_EQ(outcome.exit_code, 6);
  EXPECT_NE(outcome.err.find("mm.ply is 120 m wide"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("is one of them in millimetres?"), std::string::npos) << outcome.err;
}

TEST_F(AlignHills, InterruptedItSaysSo) {
  write_hills(path("c.ply"), 0.02, turned(-30, {0, 0, 0}));
  Program program({"align", path("a.ply"), path("b.ply"), path("c.ply"), "-o", path("out")});
  while (program.is_running() && program.err_so_far().find("comparing") == std::string::npos) {
    std::this_thread::yield();
  }
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 130);
  EXPECT_NE(outcome.err.find("interrupted while pairs of scans were compared"), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find("the mesh is empty"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(folder_ / "out" / "model.glb"));
}

TEST_F(AlignHills, AlignsAMeshButDoesNotFuseIt) {
  ASSERT_EQ(align({path("b.ply"), "-o", path("b_mesh.ply")}).exit_code, 0);
  const Outcome outcome = align({path("a.ply"), path("b_mesh.ply"), "-o", path("out"), "--points", path("all.ply")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("only range scans and recordings are fused"), std::string::npos) << outcome.err;
  const Json report = report_of(folder_ / "out");
  EXPECT_LT(error_m(report), 0.0003);
  EXPECT_NEAR(report["mesh"]["bounds_m"][1][0].get<double>(), 0.12, 0.002);
  const auto points = read_mesh(path("all.ply"));
  ASSERT_TRUE(points);
  EXPECT_GT(points->positions_m.size(), 20'000u);
  EXPECT_TRUE(points->triangles.empty());
}

TEST_F(AlignHills, WhatCannotBeReadEndsWithCode4AndItsName) {
  std::ofstream(path("bad.ply")) << read_text(path("a.ply")).substr(0, 5000);
  const Outcome cut = align({path("a.ply"), path("bad.ply"), "-o", path("out")});
  EXPECT_EQ(cut.exit_code, 4);
  EXPECT_NE(cut.err.find("bad.ply"), std::string::npos) << cut.err;
  EXPECT_NE(cut.err.find("truncated"), std::string::npos) << cut.err;
  EXPECT_EQ(align({path("nowhere.ply"), "-o", path("out")}).exit_code, 4);
  std::ofstream(path("out.conf")) << "bmesh ../a.ply 0 0 0 0 0 0 1\n";
  EXPECT_EQ(align({path("out.conf"), "-o", path("out")}).exit_code, 4);
}

fs::path bunny() {
  return test::data_folder() / "range_stanford_bunny";
}

/// Clean: hardly any piece, of the right size, manifold, and nowhere far from what was scanned.
void expect_a_clean_bunny(const fs::path& folder, const fs::path& points_file) {
  const Json report = report_of(folder);
  const Json& mesh = report["mesh"];
  EXPECT_LE(mesh["components"].get<int>(), 4);
  EXPECT_EQ(mesh["non_manifold_edges"], 0);
  const double size_m[3] = {0.156, 0.153, 0.121};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(mesh["bounds_m"][1][axis].get<double>() - mesh["bounds_m"][0][axis].get<double>(), size_m[axis], 0.003);
  }
  for (const Json& pair : report["alignment"]["pairs"]) EXPECT_NE(pair["verdict"], "unacceptable") << pair;
  const auto surface = read_mesh(folder / "model.ply");
  const auto points = read_mesh(points_file);
  ASSERT_TRUE(surface && points);
  // To the plane of the nearest scanned point: at grazing angles points lie up to 3 mm apart.
  const PointGrid grid(points->positions_m, 0.003f);
  std::size_t far = 0;
  std::size_t beside = 0;
  for (const Eigen::Vector3f& p : surface->positions_m) {
    const auto nearest = grid.nearest(p);
    const Eigen::Vector3f off = nearest ? Eigen::Vector3f(points->positions_m[*nearest] - p) : Eigen::Vector3f(1, 1, 1);
    far += !nearest || std::abs(off.dot(points->normals[*nearest])) > 0.0006f ? 1 : 0;
    beside += off.norm() > 0.0012f ? 1 : 0;
  }
  const auto vertices = static_cast<double>(surface->positions_m.size());
  std::cout << "vertices farther than 0.6 mm from the scanned surface: " << far << " of " << vertices
            << "; farther than 1.2 mm from every scanned point: " << beside << "\n";
  EXPECT_LT(static_cast<double>(far), 0.002 * vertices);
  EXPECT_LT(static_cast<double>(beside), 0.005 * vertices);
}

TEST(AlignBunny, WithItsPosesIsClean) {
  if (!fs::exists(bunny())) GTEST_SKIP() << "SKIPPED: no scans at " << bunny();
  const TempFolder out;
  const Outcome outcome = scanknit_command({"align", (bunny() / "bun.conf").string(), "-o", out.path().string(),
                                            "--points", out / "points.ply", "--set", "fusion.voxel_size=0.5mm"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("top2.ply is named, but is not there"), std::string::npos);
  expect_a_clean_bunny(out.path(), out / "points.ply");
}

TEST(AlignBunny, WithoutItsPosesIsClean) {
  if (!fs::exists(bunny())) GTEST_SKIP() << "SKIPPED: no scans at " << bunny();
  const TempFolder out;
  std::vector<std::string> arguments = {"align"};
  for (const char* name : {"bun000", "bun045", "bun090", "bun315"})
    arguments.push_back((bunny() / (std::string(name) + ".ply.gz")).string());
  for (const char* word : {"--set", "fusion.voxel_size=0.5mm", "-o"}) arguments.emplace_back(word);
  arguments.push_back(out.path().string());
  arguments.insert(arguments.end(), {"--points", (out / "points.ply").string()});
  const Outcome outcome = scanknit_command(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_a_clean_bunny(out.path(), out / "points.ply");
  // The first pose is the identity in the .conf, too; its others, transposed.
  const Json scans = report_of(out.path())["alignment"]["scans"];
  const auto expect_near = [&](std::size_t scan, const Eigen::Vector3d& t, const Eigen::Quaterniond& q) {
    const Pose found = pose_of(scans[scan]["T_world_scan"]);
    const Eigen::Vector3d middle(0, 0.1, 0.03);
    EXPECT_LT((found * middle - (q.conjugate() * middle + t)).norm(), 0.0005) << scan;
  };
  expect_near(1, {-0.0520211, -0.000383981, -0.0109223}, {0.955586, 0.00548449, -0.294635, -0.0038555});
  expect_near(2, {2.20761e-05, -3.34606e-05, -7.20881e-05}, {0.706009, 0.000335889, -0.708202, 0.000602459});
  expect_near(3, {-0.00646017, -1.36122e-05, -0.0129064}, {0.923179, 0.00449209, 0.38422, -0.00976512});
}

/// Frames `first` to `last` of a recording of synth's layout, in a world that is turned and moved.
void write_part(const fs::path& whole, const fs::path& part, int first, int last, const Pose& T_part_whole) {
  for (const char* kind : {"depth", "color"}) fs::create_directories(part / kind);
  fs::copy(whole / "camera_intrinsic.json", part / "camera_intrinsic.json");
  std::ifstream poses(whole / "trajectory.log");
  std::ofstream part_poses(part / "trajectory.log");
  part_poses.precision(17);
  for (int frame = 0; frame <= last; ++frame) {
    std::string ignored;
    std::getline(poses, ignored);
    Pose pose = Pose::Identity();
    for (int i = 0; i < 16; ++i) poses >> pose.matrix()(i / 4, i % 4);
    std::getline(poses, ignored);
    if (frame < first) continue;
    const int number = frame - first;
    part_poses << number << " " << number << " " << number + 1 << "\n" << (T_part_whole * pose).matrix() << "\n";
    for (const char* kind : {"depth", "color"}) {
      char from[16], to[16];
      std::snprintf(from, sizeof from, "%06d.png", frame);
      std::snprintf(to, sizeof to, "%06d.png", number);
      fs::copy(whole / kind / from, part / kind / to);
    }
  }
}

TEST(AlignRecordings, ThreePartsOfAScanAreFusedFromTheirFrames) {
  const TempFolder folder;
  ASSERT_EQ(scanknit_command({"synth", "turntable", "-o", folder / "whole", "--frames", "60", "--width", "320",
                              "--height", "240", "--noise", "--quiet"})
                .exit_code,
            0);
  const std::vector<Pose> truth = {
      turned(0, {0, 0, 0}), turned(77, {0.4, 0.3, -0.2}) * Pose(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitX())),
      turned(-130, {-1, 0.2, 0.5}) * Pose(Eigen::AngleAxisd(-0.8, Eigen::Vector3d::UnitY()))};
  const std::vector<std::pair<int, int>> frames = {{0, 8}, {5, 13}, {10, 20}};
  std::vector<std::string> arguments = {"align"};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const fs::path part = folder / ("part" + std::to_string(i));
    write_part(folder / "whole", part, frames[i].first, frames[i].second, truth[i]);
    arguments.push_back(part.string());
  }
  fs::resize_file(fs::path(arguments[1]) / "depth/000003.png", 100);  // costs this frame, not those after it
  arguments.insert(arguments.end(), {"-o", folder / "out", "--preset", "object"});
  const Outcome outcome = scanknit_command(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json report = report_of(folder / "out");
  EXPECT_EQ(report["frames"]["fused"], 28);
  EXPECT_EQ(report["frames"]["dropped"], 1);
  EXPECT_EQ(report["mesh"]["components"], 1);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const Pose found = pose_of(report["alignment"]["scans"][i]["T_world_scan"]);
    const Pose off = found * truth[i];
    EXPECT_LT(off.translation().norm(), 0.001) << "the figurine is about the origin of the whole scan";
    EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle() * 57.3, 0.2);
  }
}

}  // namespace
}  // namespace scanknit
