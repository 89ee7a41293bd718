// Range scans from files: what is read, and that nothing else is believed.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>

#include "acquire/range/range_files.h"
#include "tests/core/deflated.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

/// 3 x 2 cells; the first row of the file is the bottom row.
std::string ascii_grid(const std::string& vertices = "0 0 0\n1 0 0.5\n0 1 0\n1 1 0\n",
                       const std::string& cells = "1 0\n1 1\n0\n1 2\n1 3\n0\n", const std::string& count = "6") {
  return "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\nelement vertex 4\nproperty float x\n"
         "property float y\nproperty float z\nelement range_grid " +
         count + "\nproperty list uchar int vertex_indices\nend_header\n" + vertices + cells;
}

void append(std::string& bytes, float value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void append(std::string& bytes, std::int32_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The same grid in little-endian bytes, with colours.
std::string binary_grid() {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nobj_info num_cols 3\nobj_info num_rows 2\nelement vertex 4\n"
      "property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nelement range_grid 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (const auto& [x, y, z] :
       {std::array{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.5f}, {0.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 0.0f}}) {
    append(bytes, x);
    append(bytes, y);
    append(bytes, z);
    bytes += "\x0A\x14\x1E";
  }
  for (const int cell : {0, 1, -1, 2, 3, -1}) {
    bytes.push_back(cell < 0 ? '\0' : '\x01');
    if (cell >= 0) append(bytes, std::int32_t{cell});
  }
  return bytes;
}

std::string gzip(const std::string& text) {
  return deflated(text, /*is_gzip=*/true);
}

TEST(RangePly, TheFirstRowOfTheFileIsTheBottomRow) {
  const auto scan = parse_range_ply(ascii_grid(), {});
  ASSERT_TRUE(scan) << scan.error().text();
  EXPECT_EQ(scan->points_m.width(), 3);
  EXPECT_EQ(scan->points_m.height(), 2);
  EXPECT_EQ(scan->points_m.at(1, 1), Eigen::Vector3f(1, 0, 0.5f));
  EXPECT_EQ(scan->points_m.at(0, 0), Eigen::Vector3f(0, 1, 0));
  EXPECT_FALSE(has_return(scan->points_m.at(2, 0)));
}

TEST(RangePly, BinaryAndColoursAreRead) {
  const auto scan = parse_range_ply(binary_grid(), {});
  ASSERT_TRUE(scan) << scan.error().text();
  EXPECT_EQ(scan->points_m.at(1, 1), Eigen::Vector3f(1, 0, 0.5f));
  ASSERT_FALSE(scan->colours.empty());
  EXPECT_EQ(scan->colours.at(1, 1), (Rgb8{10, 20, 30}));
}

TEST(RangePly, CutAtEveryByteIsAnErrorAndNoMore) {
  for (const std::string& whole : {ascii_grid(), binary_grid()}) {
    for (std::size_t length = 0; length + 2 < whole.size(); ++length) {
      const auto scan = parse_range_ply(std::string_view(whole).substr(0, length), {});
      ASSERT_FALSE(scan) << length << " of " << whole.size();
      EXPECT_EQ(scan.error().code, ErrorCode::kInput);
    }
  }
}

TEST(RangePly, HostileNumbersAreRefusedWithWhatWasExpected) {
  const auto error = [](const std::string& bytes) {
    const auto scan = parse_range_ply(bytes, {});
    return scan ? std::string("read") : scan.error().message;
  };
  const std::string points = "0 0 0\n1 0 0.5\n0 1 0\n1 1 0\n";
  EXPECT_NE(error(ascii_grid(points, "1 0\n1 4\n0\n1 2\n1 3\n0\n")).find("names a point that is not there"),
            std::string::npos);
  EXPECT_NE(error(ascii_grid(points, "1 0\n1 -1\n0\n1 2\n1 3\n0\n")).find("names a point that is not there"),
            std::string::npos);
  EXPECT_NE(error(ascii_grid(points, "2 0 1\n1 1\n0\n1 2\n1 3\n0\n")).find("one was expected"), std::string::npos);
  EXPECT_NE(error(ascii_grid(points, "1 0\n", "7")).find("num_cols x num_rows"), std::string::npos);
  std::string huge = ascii_grid();
  huge.replace(huge.find("num_cols 3"), 10, "num_cols 9000000000000000000");
  EXPECT_NE(error(huge).find("limit"), std::string::npos);
}

TEST(RangePly, AVertexThatIsNotFiniteIsNoReturn) {
  for (const char* word : {"nan", "inf", "1e300"}) {
    const auto scan = parse_range_ply(ascii_grid("0 0 0\n1 0 " + std::string(word) + "\n0 1 0\n1 1 0\n"), {});
    ASSERT_TRUE(scan) << word << ": " << scan.error().text();
    EXPECT_FALSE(has_return(scan->points_m.at(1, 1))) << word;
    EXPECT_TRUE(has_return(scan->points_m.at(0, 1))) << word;
  }
}

TEST(RangeGzip, UnpacksAndStopsAtTheLimit) {
  const std::string text(100'000, 'x');
  const std::string packed = gzip(text);
  const auto whole = unpack_gzip(packed, 100'000);
  ASSERT_TRUE(whole);
  EXPECT_EQ(*whole, text);
  const auto bomb = unpack_gzip(packed, 50'000);
  ASSERT_FALSE(bomb);
  EXPECT_NE(bomb.error().message.find("limit"), std::string::npos);
  for (std::size_t length = 2; length < packed.size(); ++length) {
    EXPECT_FALSE(unpack_gzip(packed.substr(0, length), 100'000)) << length;
  }
}

TEST(RangeGzip, UnpacksAllMembers) {
  const auto both = unpack_gzip(gzip("first ") + gzip("second"), 100);
  ASSERT_TRUE(both) << both.error().text();
  EXPECT_EQ(*both, "first second");
  EXPECT_FALSE(unpack_gzip(gzip("first") + "something else", 100));
}

TEST(RangeGzip, BytesThatAreNotPackedStayAsTheyAre) {
  const auto same = unpack_gzip("ply\n", 100);
  ASSERT_TRUE(same);
  EXPECT_EQ(*same, "ply\n");
}

TEST(Conf, TheQuaternionIsTransposed) {
  // A quarter turn about z by the quaternion; the pose turns the other way.
  const auto scans = parse_conf("camera 0 0 0 0 0 0 1\nbmesh a.ply 1 2 3 0 0 0.70710678 0.70710678\n", {});
  ASSERT_TRUE(scans) << scans.error().text();
  ASSERT_EQ(scans->size(), 1u);
  const Eigen::Vector3d moved = (*scans)[0].T_world_scan * Eigen::Vector3d(1, 0, 0);
  EXPECT_NEAR((moved - Eigen::Vector3d(1, 1, 3)).norm(), 0, 1e-6);
}

TEST(Conf, ErrorsNameTheLine) {
  for (const char* text : {"bmesh a.ply 1 2 3 0 0 0\n", "bmesh a.ply 1 2 3 0 0 0 2\n", "bmesh a.ply 1 2 x 0 0 0 1\n",
                           "mush a.ply\n", "bmesh a.ply 1 2 nan 0 0 0 1\n"}) {
    const auto scans = parse_conf(text, {});
    ASSERT_FALSE(scans) << text;
    EXPECT_EQ(scans.error().message.rfind("line 1: ", 0), 0u) << scans.error().message;
  }
  EXPECT_FALSE(parse_conf("camera 0 0 0 0 0 0 1\n", {}));
}

std::string ptx(const std::string& points) {
  return "2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 6 7 1\n" + points;
}

TEST(Ptx, ColumnsRunFromTheBottomAndTheMatrixIsForRows) {
  const auto scans = parse_ptx(ptx("1 0 0 0.5\n2 0 0 0.5\n0 0 0 0.5\n4 0 0 1\n"), {});
  ASSERT_TRUE(scans) << scans.error().text();
  ASSERT_EQ(scans->size(), 1u);
  const RangeScan& scan = (*scans)[0];
  EXPECT_EQ(scan.points_m.at(0, 1), Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(scan.points_m.at(0, 0), Eigen::Vector3f(2, 0, 0));
  EXPECT_FALSE(has_return(scan.points_m.at(1, 1)));
  EXPECT_EQ(scan.colours.at(0, 1), (Rgb8{127, 127, 127}));
  const Eigen::Vector3d moved = *scan.T_world_scan * Eigen::Vector3d(1, 0, 0);
  EXPECT_NEAR((moved - Eigen::Vector3d(5, 7, 7)).norm(), 0, 1e-9);
}

TEST(Ptx, TwoScansInAFile) {
  const std::string one = ptx("1 0 0 0.5 1 2 3\n2 0 0 0.5 1 2 3\n3 0 0 0.5 1 2 3\n4 0 0 1 1 2 3\n");
  const auto scans = parse_ptx(one + one, {});
  ASSERT_TRUE(scans) << scans.error().text();
  EXPECT_EQ(scans->size(), 2u);
  EXPECT_EQ((*scans)[1].colours.at(0, 0), (Rgb8{1, 2, 3}));
}

TEST(Ptx, CutAtEveryLineIsAnError) {
  const std::string whole = ptx("1 0 0 0.5\n2 0 0 0.5\n3 0 0 0.5\n4 0 0 1\n");
  for (std::size_t end = whole.find('\n'); end + 1 < whole.size(); end = whole.find('\n', end + 1)) {
    EXPECT_FALSE(parse_ptx(std::string_view(whole).substr(0, end + 1), {})) << end;
  }
  EXPECT_FALSE(parse_ptx(ptx("1 0 0 0.5\n2 0 0 nan\n3 0 0 0.5\n4 0 0 1\n"), {}));
  EXPECT_FALSE(parse_ptx("1000000000\n1000000000\n", {}));
}

TEST(Ptx, APointThatIsNotFiniteIsNoReturn) {
  const auto scans = parse_ptx(ptx("1 0 0 0.5\n2 nan 0 0.5\nnan nan nan nan\n4 1e300 0 1\n"), {});
  ASSERT_TRUE(scans) << scans.error().text();
  const RangeScan& scan = (*scans)[0];
  EXPECT_TRUE(has_return(scan.points_m.at(0, 1)));
  EXPECT_FALSE(has_return(scan.points_m.at(0, 0)));
  EXPECT_FALSE(has_return(scan.points_m.at(1, 1)));
  EXPECT_FALSE(has_return(scan.points_m.at(1, 0)));
}

TEST(RangePcd, OrganisedIsAScanAndOneRowIsACloud) {
  const std::string head =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 "
      "1 1 1 1 1\n";
  const std::string body =
      "VIEWPOINT 1 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n0 0 1 0 0 -1\n1 0 1 0 0 -1\nnan nan nan 0 0 0\n1 1 1 0 0 -1\n";
  const auto scan = parse_pcd_range(head + "WIDTH 2\nHEIGHT 2\n" + body, {});
  ASSERT_TRUE(scan) << scan.error().text();
  ASSERT_EQ(scan->scans.size(), 1u);
  EXPECT_FALSE(has_return(scan->scans[0].points_m.at(0, 1)));
  EXPECT_EQ(scan->scans[0].T_world_scan->translation(), Eigen::Vector3d(1, 0, 0));
  const auto cloud = parse_pcd_range(head + "WIDTH 4\nHEIGHT 1\n" + body, {});
  ASSERT_TRUE(cloud) << cloud.error().text();
  ASSERT_EQ(cloud->clouds.size(), 1u);
  EXPECT_EQ(cloud->clouds[0].points_m.size(), 3u);
  EXPECT_EQ(cloud->clouds[0].normals.size(), 3u);
}

// Rays of a row lie in a plane: a sheet of light moved along x, seen from 1 m away.
TEST(SightLines, AreFoundFromTheGrid) {
  Image<Eigen::Vector3f> points(60, 60, kNoReturn);
  const Eigen::Vector3d eye(0, 0.1, 1.0);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 60; ++x) {
      const double z = 0.03 * std::sin(0.3 * x) * std::cos(0.2 * y);
      const double at_zero = 0.001 * (30 - y) + 0.05;
      points.at(x, y) = Eigen::Vector3d(0.001 * x, at_zero + (eye.y() - at_zero) * z / eye.z(), z).cast<float>();
    }
  }
  const test::TemporaryFolder folder;
  std::string ply =
      "ply\nformat ascii 1.0\nobj_info num_cols 60\nobj_info num_rows 60\nelement vertex 3600\nproperty float "
      "x\nproperty float y\nproperty float z\nelement range_grid 3600\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  for (int y = 59; y >= 0; --y) {
    for (int x = 0; x < 60; ++x) {
      const Eigen::Vector3f& p = points.at(x, y);
      ply += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    }
  }
  for (int i = 0; i < 3600; ++i) ply += "1 " + std::to_string(i) + "\n";
  std::ofstream(folder.path() / "sheet.ply.gz", std::ios::binary) << gzip(ply);
  const auto file = read_range_file(folder.path() / "sheet.ply.gz");
  ASSERT_TRUE(file) << file.error().text();
  const SightLines& sight = file->scans.at(0).sight;
  EXPECT_NEAR(sight.slit_per_m.x(), 0, 0.02);
  EXPECT_NEAR(1 / sight.slit_per_m.y() + sight.centre.z(), eye.z(), 0.02);
  const Eigen::Vector3d direction = sight.direction({0.02, 0.05, 0});
  EXPECT_NEAR((direction - (Eigen::Vector3d(0.02, 0.05, 0) - Eigen::Vector3d(0.02, 0.1, 1)).normalized()).norm(), 0,
              0.005);
}

}  // namespace
}  // namespace scanknit
