// `measure`, and `distance` with a mesh as the reference, as a user calls them.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "export/mesh/write_mesh.h"
#include "tests/app/suite_folder.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Measure : public SuiteFolder {
 protected:
  /// Writes a mesh with the numbers that it has.
  static std::string written(const std::string& name, const Mesh& mesh) {
    const auto done = write_mesh(mesh, place(name), {}, UpAxis::kMinusY);
    EXPECT_TRUE(done) << done.error().text();
    return place(name);
  }
  static std::string text_file(const std::string& name, const std::string& text) {
    std::ofstream(place(name)) << text;
    return place(name);
  }
  static Outcome distance(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "distance");
    return scanknit_command(arguments);
  }
  static Outcome measure(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "measure");
    return scanknit_command(arguments);
  }
  static bool says(const Outcome& outcome, const std::string& text) {
    return (outcome.out + outcome.err).find(text) != std::string::npos;
  }
};

TEST_F(Measure, ToleranceDecidesTheExitCode) {
  const std::string larger = written("larger.ply", test::ball(0.0502)), ball = written("ball.ply", test::ball(0.05));
  const Outcome kept = distance({larger, ball, "--tolerance", "0.21mm", "--json"});
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_TRUE(Json::parse(kept.out)["tolerance"]["is_within"]);
  const Outcome beyond = distance({larger, ball, "--tolerance", "0.15mm", "--json"});
  EXPECT_EQ(beyond.exit_code, 7);
  const Json json = Json::parse(beyond.out);
  EXPECT_EQ(json["tolerance"]["share_beyond_vertices"], 1.0);
  EXPECT_NEAR(json["area"]["mean_m"], 0.0002, 2e-6);
  EXPECT_NEAR(json["reference_area"]["mean_m"], -0.0002, 2e-6);
  EXPECT_TRUE(says(beyond, "100 % of the vertices and 100 % of the area are beyond the tolerance of 0.15 mm"))
      << beyond.err;
  EXPECT_EQ(distance({larger, ball, "--tolerance", "0.15mm", "--allowed", "100"}).exit_code, 0);
  EXPECT_EQ(distance({larger, ball, "--tolerance", "soft"}).exit_code, 2);
  EXPECT_EQ(distance({larger, ball, "--allowed", "3"}).exit_code, 2);
}

TEST_F(Measure, AReferenceInAnotherUnitIsNamedAndTaken) {
  const std::string ball = written("ball.ply", test::ball(0.05));
  const std::string in_mm = written("in_mm.ply", test::ball(50));
  const std::string in_inches = written("in_inches.ply", test::ball(50 / 25.4));
  const Outcome unknown = distance({ball, in_mm});
  EXPECT_EQ(unknown.exit_code, 4);
  EXPECT_TRUE(says(unknown, "--reference-unit mm")) << unknown.err;
  EXPECT_TRUE(says(distance({ball, in_inches}), "--reference-unit inch"));
  for (const auto& [file, unit] : {std::pair(in_mm, "mm"), std::pair(in_inches, "inch")}) {
    const Outcome known = distance({ball, file, "--reference-unit", unit, "--json"});
    ASSERT_EQ(known.exit_code, 0) << known.err;
    EXPECT_LT(Json::parse(known.out)["area"]["max_absolute_m"], 1e-7);
  }
  // STL has millimetres: write_mesh() scales, and so do we when we read it.
  const std::string stl = written("ball.stl", test::ball(0.05));
  const Outcome same = distance({stl, stl, "--json"});
  EXPECT_LT(Json::parse(same.out)["area"]["max_absolute_m"], 1e-9);
  EXPECT_NEAR(Json::parse(measure({stl, "--json"}).out)["oriented_box"]["size_m"][0], 0.1, 1e-4);
}

TEST_F(Measure, AMeshIsAlignedByShapeByPairsAndByAMatrix) {
  const Mesh lump = test::lump();
  const Pose T_reference_mesh = test::some_pose();
  const std::string mesh = written("lump.ply", lump), moved = written("moved.ply", test::moved(lump, T_reference_mesh));
  EXPECT_GT(Json::parse(distance({mesh, moved, "--json"}).out)["area"]["rms_m"], 0.1);
  const Outcome by_shape = distance({mesh, moved, "--align", "shape", "--json"});
  ASSERT_EQ(by_shape.exit_code, 0) << by_shape.err;
  EXPECT_LT(Json::parse(by_shape.out)["area"]["max_absolute_m"], 5e-6);

  std::string pairs, matrix;
  for (const std::size_t i : {0u, 1000u, 3000u}) {
    const Eigen::Vector3d p = lump.positions_m[i].cast<double>(), q = T_reference_mesh * p;
    pairs += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + " " +
             std::to_string(q.x()) + " " + std::to_string(q.y()) + " " + std::to_string(q.z()) + "\n";
  }
  for (const double number : T_reference_mesh.matrix().transpose().reshaped()) matrix += std::to_string(number) + " ";
  const std::string pairs_file = text_file("pairs.txt", pairs), matrix_file = text_file("matrix.txt", matrix);
  const Json by_pairs = Json::parse(distance({mesh, moved, "--pairs", pairs_file, "--json"}).out);
  EXPECT_LT(by_pairs["area"]["max_absolute_m"], 1e-4);  // the file has six digits
  const Json fitted = Json::parse(distance({mesh, moved, "--pairs", pairs_file, "--align", "near", "--json"}).out);
  EXPECT_LT(fitted["area"]["max_absolute_m"], 5e-6);
  EXPECT_NEAR(fitted["alignment"]["T_reference_mesh"][0][3], T_reference_mesh.translation().x(), 1e-5);
  EXPECT_LT(Json::parse(distance({mesh, moved, "--matrix", matrix_file, "--json"}).out)["area"]["max_absolute_m"],
            5e-6);
  EXPECT_EQ(distance({mesh, moved, "--pairs", text_file("bad.txt", "1 2 3\n")}).exit_code, 4);
  EXPECT_EQ(distance({mesh, moved, "--pairs", pairs_file, "--matrix", matrix_file}).exit_code, 2);
}

TEST_F(Measure, DistanceWritesAColouredMeshAPictureAndAHistogram) {
  const std::string dented = written("dented.ply", test::sheet(0.1, 100, 0.002)),
                    flat = written("flat.ply", test::sheet(0.1, 10));
  const std::string out = place("deviation");
  const Outcome outcome = distance({dented, flat, "-o", out, "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(says(outcome, "open")) << outcome.err;  // signs are of front and back
  const Json json = Json::parse(outcome.out);
  EXPECT_NEAR(json["vertices"]["min_m"], -0.002, 2e-5);
  EXPECT_EQ(Json::parse(read_text(fs::path(out) / "distance.json")), json);
  EXPECT_TRUE(read_text(fs::path(out) / "histogram.svg").ends_with("</svg>\n"));
  const std::string page = read_text(fs::path(out) / "report.html");
  EXPECT_TRUE(page.ends_with("</html>\n"));
  EXPECT_NE(page.find("Deviation of dented.ply"), std::string::npos);
  EXPECT_EQ(json["regions"].size(), 9u) << "a sheet has no thickness";
  EXPECT_TRUE(read_text(fs::path(out) / "deviation.png").starts_with("\x89PNG"));
  const Json described = Json::parse(scanknit_command({"info", out + "/deviation.ply", "--json"}).out);
  EXPECT_TRUE(described["has_colours"]);
  EXPECT_EQ(described["vertices"], 101 * 101);
}

TEST_F(Measure, DistanceAsksForUnitsWhereSizesDifferAsUnitsDo) {
  const std::string part = written("part.ply", test::sheet(0.1, 10)),
                    larger = written("larger.ply", test::sheet(2.54, 10)),
                    model = text_file("part.step", "ISO-10303-21;\n");
  for (const auto& [mesh, reference] : {std::pair(part, larger), std::pair(larger, part)}) {
    const Outcome refused = distance({mesh, reference});
    EXPECT_EQ(refused.exit_code, 4);
    EXPECT_TRUE(says(refused, "inches and the other in millimetres")) << refused.err;
  }
  EXPECT_EQ(distance({part, larger, "--reference-unit", "m"}).exit_code, 0);
  const Outcome step = distance({part, model});
  EXPECT_EQ(step.exit_code, 4);
  EXPECT_TRUE(says(step, "part.step: ") && says(step, "STEP")) << step.err;
}

TEST_F(Measure, WhatCannotBeMeasuredIsSaid) {
  const std::string ball = written("ball.ply", test::ball(0.05));
  const std::string empty = text_file("empty.ply",
                                      "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float "
                                      "y\nproperty float z\nelement face 0\nproperty list uchar int "
                                      "vertex_indices\nend_header\n");
  for (const Outcome& outcome : {distance({empty, ball}), distance({ball, empty}), measure({empty})}) {
    EXPECT_TRUE(outcome.exit_code == 7 || outcome.exit_code == 4) << outcome.exit_code << outcome.err;
    EXPECT_TRUE(says(outcome, "empty.ply")) << outcome.err;
  }
  EXPECT_EQ(measure({place("missing.ply")}).exit_code, 4);
  EXPECT_EQ(distance({ball, place("missing.ply")}).exit_code, 4);
  fs::create_directory(place("folder"));
  EXPECT_EQ(distance({ball, place("folder"), "--tolerance", "1mm"}).exit_code, 2);
  EXPECT_EQ(measure({ball, "--plane-at", "0,0,0"}).exit_code, 2);  // needs --radius
  EXPECT_EQ(measure({ball, "--plane-at", "0,0,0", "--radius", "1mm"}).exit_code, 6);
  for (const char* plane : {"w=3", "z=", "1,2,3", "0,0,0,0,0,0", "0,0,0,1,nan,0", ""}) {
    EXPECT_EQ(measure({ball, "--section", plane}).exit_code, 2) << plane;
  }
}

TEST_F(Measure, APlateIsMeasured) {
  const std::string plate =
      written("plate.ply", test::moved(test::plate_with_hole(0.06, 0.004, 0.01), test::some_pose()));
  const Eigen::Vector3d centre = test::some_pose().translation(), up = test::some_pose().linear().col(2);
  const Eigen::Vector3d top = test::some_pose() * Eigen::Vector3d(0.02, 0.02, 0.002);
  const auto numbers = [](const Eigen::Vector3d& v) {
    return std::to_string(v.x()) + "," + std::to_string(v.y()) + "," + std::to_string(v.z());
  };
  const std::string out = place("measures");
  const Outcome outcome =
      measure({plate, "--json", "-o", out, "--thin", "5mm", "--section", numbers(centre) + "," + numbers(up),
               "--circle-at", numbers(centre), "--radius", "14mm"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  const double disc = std::numbers::pi * 0.01 * 0.01, volume = (0.06 * 0.06 - disc) * 0.004;
  EXPECT_NEAR(json["volume_m3"], volume, 0.01 * volume);
  EXPECT_NEAR(json["oriented_box"]["size_m"][2], 0.004, 4e-5);
  EXPECT_NEAR(json["oriented_box"]["size_m"][0], 0.06, 6e-4);
  const double area = 2 * (0.06 * 0.06 - disc) + 4 * 0.06 * 0.004 + 2 * std::numbers::pi * 0.01 * 0.004;
  EXPECT_NEAR(json["area_m2"], area, 0.01 * area);
  EXPECT_TRUE(json["holes"].empty());
  EXPECT_NEAR(json["thickness"]["median_m"], 0.004, 4e-5);
  EXPECT_NEAR(json["thickness"]["share_thin"], 2 * (0.06 * 0.06 - disc) / area, 0.01);
  EXPECT_NEAR(json["sections"][0]["area_m2"], 0.06 * 0.06 - disc, 0.01 * 0.06 * 0.06);
  EXPECT_EQ(json["sections"][0]["outlines"].size(), 2u);
  EXPECT_NEAR(json["circle"]["diameter_m"], 0.02, 0.0002);
  EXPECT_TRUE(json["circle"]["is_hole"]);
  EXPECT_TRUE(fs::exists(out + "/section_1.svg") && fs::exists(out + "/section_1.dxf"));
  const Json face = Json::parse(measure({plate, "--json", "--plane-at", numbers(top), "--radius", "5mm"}).out)["plane"];
  EXPECT_NEAR(std::abs(face["normal"][0].get<double>()), std::abs(up.x()), 1e-4);
  EXPECT_LT(face["flatness_m"], 1e-6);
}

TEST_F(Measure, AnOpenMeshHasNoVolumeAndSaysWhatItWouldBe) {
  Mesh open = test::box(0.02, 0.03, 0.05);
  open.triangles.pop_back();
  const std::string file = written("open.ply", open);
  const Json json = Json::parse(measure({file, "--json"}).out);
  EXPECT_TRUE(json["volume_m3"].is_null());
  EXPECT_NEAR(json["volume_with_covered_holes_m3"], 3e-5, 1e-10);
  EXPECT_EQ(json["holes"].size(), 1u);
  const Outcome lines = measure({file});
  EXPECT_TRUE(says(lines, "none, because the mesh is open; with its holes covered about 30000 mm3")) << lines.out;
}

TEST_F(Measure, LengthsWithoutAUnitAreInTheFilesUnit) {
  const std::string box = written("box_in_mm.ply", test::box(20, 30, 50));
  for (const char* section : {"z=10", "z=10mm", "z=1cm"}) {
    const Json json = Json::parse(measure({box, "--unit", "mm", "--section", section, "--json"}).out);
    EXPECT_NEAR(json["sections"][0]["area_m2"], 0.02 * 0.03, 1e-9) << section;
    EXPECT_NEAR(json["sections"][0]["offset_m"], 0.01, 1e-12) << section;
  }
}

}  // namespace
}  // namespace scanknit
