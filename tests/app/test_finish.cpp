// `finish:` by the built program: a noisy desk with things on it, seen from above.
#include <gtest/gtest.h>

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>

#include "scan/checks/memory_share.h"
#include "tests/app/suite_folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Finish : public SuiteFolder {
 protected:
  static void SetUpTestSuite() {
    SuiteFolder::SetUpTestSuite();
    const Outcome synth = scanknit_command({"synth", "desk", "--noise", "--seed", "1", "-o", recording(), "--frames",
                                            "40", "--width", "240", "--height", "180", "--quiet"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
    const Outcome plain = run("plain", {"--save-volume", place("plain.vdb")});
    ASSERT_EQ(plain.exit_code, 0) << plain.err;
  }
  static Outcome run(const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "run",   recording(),         "-o", place(name), "--preset", "object", "--set", "fusion.voxel_size=4mm",
        "--set", "finish.crumbs=keep"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  static Json step(const Json& report, const std::string& name) {
    for (const Json& one : report["finish"]["steps"]) {
      if (one["name"] == name) return one;
    }
    return nullptr;
  }
  static double size_m(const Json& report, int axis) {
    const Json& bounds = report["mesh"]["bounds_m"];
    return bounds[1][axis].get<double>() - bounds[0][axis].get<double>();
  }
};

TEST_F(Finish, NothingIsDoneUnlessAsked) {
  EXPECT_TRUE(report("plain")["finish"].is_null());
  EXPECT_EQ(report("plain")["mesh"]["is_closed"], false);
}

// The desk's four legs have ghosts inside: the far side of each, seen by few frames.
TEST_F(Finish, WithoutAWishOnlyCrumbsAreLeftOutAndCounted) {
  const Outcome outcome = run("clean", {"--set", "finish.crumbs=remove"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json told = report("clean");
  EXPECT_EQ(told["finish"]["steps"].size(), 1u);
  const int removed = step(told, "crumbs")["figures"]["pieces_removed"].get<int>();
  EXPECT_GT(removed, 0);
  EXPECT_EQ(report("plain")["mesh"]["components"].get<int>() - told["mesh"]["components"].get<int>(), removed);
  EXPECT_NE(outcome.out.find("crumbs: "), std::string::npos) << outcome.out;
}

TEST_F(Finish, ForPrintingItIsCutFromTheTableClosedAndStandsOnTheOrigin) {
  const Outcome outcome = run("print", {"--preset", "print", "--set", "finish.mark_invented=magenta"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json told = report("print");
  std::cout << told["finish"].dump(1) << "\n";
  EXPECT_EQ(told["mesh"]["is_closed"], true);
  EXPECT_EQ(told["mesh"]["is_manifold"], true);
  // Seven pieces: a mug whose handle is a ring, a vase, a ball, books, a ring, a cone, a box. Two have a hole.
  EXPECT_EQ(told["mesh"]["components"], 7);
  EXPECT_EQ(told["mesh"]["euler"], 2 * 7 - 2 * 2);
  EXPECT_EQ(told["mesh"]["degenerate_triangles"], 0);
  EXPECT_EQ(step(told, "ground")["refused"], "");
  EXPECT_LT(step(told, "ground")["figures"]["plane_rms_mm"].get<double>(), 4);
  EXPECT_GT(step(told, "watertight")["figures"]["invented_area_mm2"].get<double>(), 0);
  EXPECT_EQ(step(told, "watertight")["figures"]["boundary_edges"], 0);
  EXPECT_NEAR(told["mesh"]["bounds_m"][1][1].get<double>(), 0, 1e-6);  // -y is up: it stands on y = 0
  EXPECT_NEAR(size_m(told, 1), 0.22 - 0.008, 0.006);  // the vase, without the two voxels above the table
  EXPECT_NEAR(told["mesh"]["bounds_m"][0][0].get<double>(), -told["mesh"]["bounds_m"][1][0].get<double>(), 1e-6);
  EXPECT_NE(outcome.out.find("Finish"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find(" mm2, invented "), std::string::npos) << outcome.out;  // words, and no keys
  EXPECT_EQ(outcome.out.find("_mm2"), std::string::npos) << outcome.out;
  EXPECT_TRUE(fs::exists(fs::path(place("print")) / "model.stl"));
}

TEST_F(Finish, IsTheSameBytesForAnyNumberOfThreads) {
  std::vector<std::string> meshes;
  for (const char* threads : {"1", "2", "8"}) {
    const Outcome outcome = scanknit_command({"extract", place("plain.vdb"), "-o", place("threads.stl"), "--preset",
                                              "object", "--preset", "print", "--set", "finish.triangles=20000", "--set",
                                              "finish.smooth=2", "--threads", threads, "--quiet"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    meshes.push_back(read_text(place("threads.stl")));
  }
  EXPECT_FALSE(meshes[0].empty());
  EXPECT_TRUE(meshes[1] == meshes[0]);
  EXPECT_TRUE(meshes[2] == meshes[0]);
}

TEST_F(Finish, TheSavedVolumeIsFinishedTheSameWay) {
  const std::vector<std::string> wish = {"--set", "finish.watertight=small", "--set", "finish.max_hole=4cm"};
  const Outcome whole = run("small", wish);
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  std::vector<std::string> arguments = {"extract", place("plain.vdb"), "-o", place("extracted"), "--preset", "object"};
  arguments.insert(arguments.end(), wish.begin(), wish.end());
  const Outcome extracted = scanknit_command(arguments);
  ASSERT_EQ(extracted.exit_code, 0) << extracted.err;
  EXPECT_EQ(read_text(place("small") + "/model.ply"), read_text(place("extracted") + "/model.ply"));
  const Json told = report("small");
  EXPECT_GT(step(told, "watertight")["figures"]["holes_closed"].get<double>(), 0);
  EXPECT_LT(told["mesh"]["boundary_edges"], report("plain")["mesh"]["boundary_edges"]);
  EXPECT_EQ(told["mesh"]["is_manifold"], true);
}

TEST_F(Finish, CropsSmoothsAndSimplifies) {
  const Json plain = report("plain");
  const double middle =
      (plain["mesh"]["bounds_m"][0][0].get<double>() + plain["mesh"]["bounds_m"][1][0].get<double>()) / 2;
  const Outcome outcome = run("crop", {"--set", "finish.crop.max_x=" + std::to_string(middle), "--set",
                                       "finish.triangles=2000", "--set", "finish.smooth=2"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json told = report("crop");
  std::cout << told["finish"].dump(1) << "\n";
  EXPECT_LE(told["mesh"]["bounds_m"][1][0].get<double>(), middle + 1e-6);
  EXPECT_NEAR(size_m(told, 0), size_m(plain, 0) / 2, 0.02);
  EXPECT_LT(told["mesh"]["triangles"], 2300);
  EXPECT_EQ(told["mesh"]["is_manifold"], true);
  EXPECT_GT(step(told, "smooth")["figures"]["mean_moved_mm"].get<double>(), 0);
}

/// The volume of a file, elsewhere in the world.
void move_volume(const std::string& from, const std::string& to,
                 const std::function<void(openvdb::math::Transform&)>& move) {
  openvdb::initialize();
  openvdb::io::File file(from);
  file.open();
  const openvdb::GridPtrVecPtr grids = file.getGrids();
  for (const auto& grid : *grids) move(grid->transform());
  openvdb::io::File(to).write(*grids);
}

TEST_F(Finish, CropsAMirroredVolumeAndLeavesATurnedOneWhole) {
  const Json plain = report("plain");
  const double middle =
      (plain["mesh"]["bounds_m"][0][0].get<double>() + plain["mesh"]["bounds_m"][1][0].get<double>()) / 2;
  const auto extract = [&](const std::string& volume, double most_x) {
    return scanknit_command({"extract", volume, "-o", place("moved"), "--preset", "object", "--set",
                             "finish.crop.max_x=" + std::to_string(most_x)});
  };
  move_volume(place("plain.vdb"), place("mirrored.vdb"), [](auto& transform) { transform.postScale({-1, 1, 1}); });
  const Outcome mirrored = extract(place("mirrored.vdb"), -middle);
  ASSERT_EQ(mirrored.exit_code, 0) << mirrored.err;
  EXPECT_LE(report("moved")["mesh"]["bounds_m"][1][0].get<double>(), -middle + 1e-6);
  EXPECT_NEAR(size_m(report("moved"), 0), size_m(plain, 0) / 2, 0.02);

  move_volume(place("plain.vdb"), place("turned.vdb"),
              [](auto& transform) { transform.postRotate(0.5, openvdb::math::Z_AXIS); });
  const Outcome turned = extract(place("turned.vdb"), middle);
  ASSERT_EQ(turned.exit_code, 0) << turned.err;
  EXPECT_NE(step(report("moved"), "crop")["refused"].get<std::string>().find("turned against"), std::string::npos);
  EXPECT_NE(turned.err.find("crop was not done"), std::string::npos) << turned.err;
  EXPECT_EQ(report("moved")["mesh"]["triangles"], plain["mesh"]["triangles"]);
}

TEST_F(Finish, WarnsOfAStepThatCannotBeDoneAndWritesTheMesh) {
  const Outcome outcome = run("refused", {"--set", "finish.watertight=full", "--set", "fusion.memory_budget=100MiB"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string reason = step(report("refused"), "watertight")["refused"];
  EXPECT_NE(reason.find("finish.crop"), std::string::npos) << reason;
  EXPECT_EQ(reason.find("finish.watertight"), std::string::npos) << reason;  // the line begins with the step's name
  EXPECT_NE(outcome.out.find("not done"), std::string::npos) << outcome.out;
  EXPECT_TRUE(fs::exists(fs::path(place("refused")) / "model.ply"));
}

TEST_F(Finish, DoesNotSimplifyBeyondTheMemoryBudget) {
  const std::string program = std::to_string(kProgramMib) + "MiB";  // nothing is left for the step
  ASSERT_EQ(
      run("unsimplified", {"--set", "finish.triangles=100", "--set", "fusion.memory_budget=" + program}).exit_code, 0);
  const Json simplify = step(report("unsimplified"), "simplify");
  EXPECT_NE(simplify["refused"].get<std::string>().find("fusion.memory_budget"), std::string::npos) << simplify;
  EXPECT_GT(report("unsimplified")["mesh"]["triangles"], 100);
}

TEST_F(Finish, PiecesThatAreNotClosedSinceTheyGoAreCounted) {
  const std::vector<std::string> cut = {"--set", "finish.ground=cap", "--set", "finish.watertight=full"};
  ASSERT_EQ(run("all_pieces", cut).exit_code, 0);
  std::vector<std::string> wish = cut;
  wish.insert(wish.end(), {"--set", "finish.min_piece_share=0.9"});
  ASSERT_EQ(run("largest_piece", wish).exit_code, 0);
  const Json all = report("all_pieces");
  const Json largest = report("largest_piece");
  ASSERT_EQ(all["mesh"]["components"], 7);
  ASSERT_EQ(largest["mesh"]["components"], 1);
  const Json figures = step(largest, "pieces")["figures"];
  std::cout << figures << "\n";
  EXPECT_EQ(figures["pieces_removed"], 6);
  // Closed, the same six have what was invented of them, too.
  const auto triangles = [](const Json& of) { return of["mesh"]["triangles"].get<double>(); };
  EXPECT_LT(figures["triangles_removed"].get<double>(), triangles(all) - triangles(largest));
  EXPECT_GT(figures["triangles_removed"].get<double>(), 0.7 * (triangles(all) - triangles(largest)));
  // A triangle of 4 mm voxels has about half the area of a voxel's face.
  EXPECT_NEAR(figures["area_removed_mm2"].get<double>() / figures["triangles_removed"].get<double>(), 7, 3);
}

TEST_F(Finish, ACutThatWouldLeaveNothingIsNotDone) {
  const Outcome outcome = run("nothing", {"--set", "finish.ground=remove", "--set", "finish.ground_clearance=1m"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string reason = step(report("nothing"), "ground")["refused"];
  EXPECT_NE(reason.find("finish.ground_clearance"), std::string::npos) << reason;
  EXPECT_NE(outcome.err.find(reason), std::string::npos) << outcome.err;
  EXPECT_EQ(read_text(place("nothing") + "/model.ply"), read_text(place("plain") + "/model.ply"));
}

TEST_F(Finish, WhereNothingIsAboveTheGroundTheRestIsDone) {
  const Outcome synth = scanknit_command(
      {"synth", "sphere", "-o", place("ball"), "--frames", "2", "--width", "40", "--height", "30", "--quiet"});
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  const Outcome outcome =
      scanknit_command({"run", place("ball"), "-o", place("cap_of_ball"), "--preset", "print", "--set",
                        "extract.min_component_triangles=0", "--set", "fusion.voxel_size=2cm"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json told = report("cap_of_ball");
  EXPECT_NE(step(told, "ground")["refused"].get<std::string>().find("finish.up"), std::string::npos) << told["finish"];
  EXPECT_EQ(step(told, "place")["figures"]["turned_degrees"], 0);
  EXPECT_EQ(told["mesh"]["is_closed"], true);
}

TEST_F(Finish, KeysOfStepsThatAreOffAreWarnedOf) {
  const std::vector<std::string> keys = {"--set", "finish.max_hole=3cm",         "--set", "finish.mark_invented=red",
                                         "--set", "finish.ground_clearance=1cm", "--set", "finish.smooth=1"};
  const Outcome off = run("off", keys);
  ASSERT_EQ(off.exit_code, 0) << off.err;
  const std::string of_holes =
      "finish.max_hole and finish.mark_invented have no effect because finish.watertight is off";
  EXPECT_NE(off.err.find(of_holes), std::string::npos) << off.err;
  EXPECT_EQ(report("off")["warnings"],
            Json::array({"finish.ground_clearance has no effect because finish.ground is keep", of_holes}));
  std::vector<std::string> full = keys;
  full.insert(full.end(), {"--set", "finish.ground=remove", "--set", "finish.watertight=full"});
  const Outcome closed = run("closed_whatever", full);
  ASSERT_EQ(closed.exit_code, 0) << closed.err;
  EXPECT_EQ(report("closed_whatever")["warnings"],
            Json::array({"finish.max_hole has no effect because finish.watertight: full closes every hole"}));
  std::vector<std::string> wish = keys;
  wish.insert(wish.end(), {"--set", "finish.ground=remove", "--set", "finish.watertight=small"});
  const Outcome on = run("on", wish);
  ASSERT_EQ(on.exit_code, 0) << on.err;
  EXPECT_EQ(report("on")["warnings"], Json::array()) << on.err;
}

TEST_F(Finish, AKeyThatIsSetToItsBuiltInValueIsWarnedOfToo) {
  const Outcome outcome = run("built_in", {"--set", "finish.max_hole=20mm"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(report("built_in")["warnings"],
            Json::array({"finish.max_hole has no effect because finish.watertight is off"}));
}

TEST_F(Finish, ACapThatNothingDrawsIsRefusedBeforeTheWork) {
  const Outcome outcome = run("cap", {"--set", "finish.ground=cap"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.err.find("finish.watertight: full"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(place("cap")));
}

}  // namespace
}  // namespace scanknit
