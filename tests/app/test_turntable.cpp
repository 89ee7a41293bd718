// Recordings of a turntable whose axis and angles nobody knows, by the built program.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <thread>

#include "tests/app/suite_folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::vector<std::string> lines_of(const fs::path& file) {
  std::istringstream text(read_text(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::string picture_name(int frame) {
  const std::string digits = std::to_string(frame);
  return std::string(6 - digits.size(), '0') + digits + ".png";
}

/// Some frames of a recording, numbered anew, with their angles; [begin, end) each.
void copy_frames(const fs::path& from, const fs::path& to, const std::vector<std::pair<int, int>>& ranges) {
  fs::create_directories(to / "depth");
  fs::create_directories(to / "color");
  for (const char* file : {"camera_intrinsic.json", "ground_truth.json", "visible_points.ply"})
    fs::copy(from / file, to / file);
  const std::vector<std::string> angles = lines_of(from / "angles.txt");
  const std::vector<std::string> poses = lines_of(from / "true_poses.log");  // a heading and a 4 x 4 matrix each
  std::ofstream kept_angles(to / "angles.txt"), kept_poses(to / "true_poses.log");
  int next = 0;
  for (const auto& [begin, end] : ranges) {
    for (int frame = begin; frame < end; ++frame, ++next) {
      for (const char* folder : {"depth", "color"})
        fs::copy(from / folder / picture_name(frame), to / folder / picture_name(next));
      const auto place = static_cast<std::size_t>(frame);
      kept_angles << angles.at(place) << '\n';
      kept_poses << next << ' ' << next << ' ' << next + 1 << '\n';
      for (std::size_t row = 1; row < 5; ++row) kept_poses << poses.at(5 * place + row) << '\n';
    }
  }
}

/// Blocks on each other, all of which is seen but the underside, in a noisy recording of one turn before a wall; a hand
/// reaches in. Angles are up to a degree and a half from steady.
class Tower : public SuiteFolder {
 protected:
  static void SetUpTestSuite() {
    SuiteFolder::SetUpTestSuite();
    const Outcome synth =
        scanknit_command({"synth", "tower", "--turntable", "--hand", "--angle-noise", "0.5", "--noise", "-o",
                          recording(), "--frames", "48", "--width", "240", "--height", "180", "--quiet"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
    const Outcome found = scan(recording(), place("found"), {"--cut-recording", place("cut")});
    ASSERT_EQ(found.exit_code, 0) << found.err;
  }

  static Outcome scan(const std::string& input, const std::string& output, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {
        "run", input, "--preset", "turntable", "-o", output, "--set", "fusion.voxel_size=2mm", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  static bool has_warning(const std::string& output, const std::string& text) {
    return report(output)["warnings"].dump().find(text) != std::string::npos;
  }
  static double mean_error_m(const std::string& output, const std::string& truth = recording()) {
    const Outcome distance = scanknit_command(
        {"distance", output + "/model.ply", truth, "--trajectory", output + "/trajectory.txt", "--json"});
    EXPECT_EQ(distance.exit_code, 0) << distance.err;
    return Json::parse(distance.out)["area"]["mean_m"].get<double>();
  }
};

TEST_F(Tower, FinishingWarnsOnceAlthoughTheMeshIsWrittenTwice) {
  const Outcome outcome = scanknit_command({"run", recording(), "--preset", "turntable", "--preset", "print", "--set",
                                            "fusion.voxel_size=4mm", "-o", place("print")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(report(place("print"))["turntable"]["is_refined"], true);
  const std::string warning = "ground was not done";  // the table has been cut away
  const std::size_t first = outcome.err.find(warning);
  ASSERT_NE(first, std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find(warning, first + 1), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find("pcl::"), std::string::npos) << outcome.err;  // what found no plane does not say so itself
}

TEST_F(Tower, IsAsExactAsWithTruePosesClosedAndAlone) {
  const std::string with_poses = place("with_poses");
  fs::copy(recording(), with_poses, fs::copy_options::recursive);
  fs::rename(with_poses + "/true_poses.log", with_poses + "/trajectory.log");
  ASSERT_EQ(scan(with_poses, place("true")).exit_code, 0);

  const double found_m = mean_error_m(place("found"));
  const double true_m = mean_error_m(place("true"));
  std::cout << "mean error " << 1000 * found_m << " mm; with true poses " << 1000 * true_m << " mm\n";
  EXPECT_LE(found_m, 1.5 * true_m);

  const Json found = report(place("found"));
  const Json& mesh = found["mesh"];
  EXPECT_EQ(mesh["components"], 1);  // no wall, no table, no hand
  EXPECT_EQ(mesh["is_closed"], true);
  EXPECT_EQ(mesh["is_manifold"], true);
  EXPECT_EQ(mesh["euler"], 2);
  const Json& bounds = mesh["bounds_m"];
  constexpr double kAround_m = 0.004;                                                    // noise at rims: three sigma
  EXPECT_NEAR(bounds[1][1].get<double>(), 0, 0.003);                                     // it stands on the origin,
  EXPECT_NEAR(bounds[0][1].get<double>(), -0.192, kAround_m);                            // 19.2 cm high
  EXPECT_LT(bounds[1][0].get<double>() - bounds[0][0].get<double>(), 0.16 + kAround_m);  // its diagonal

  const Json& table = found["turntable"];
  EXPECT_EQ(table["is_refined"], true);
  EXPECT_EQ(table["is_closed"], true);
  EXPECT_EQ(table["is_angle_held"], true);
  EXPECT_EQ(table["cut"]["still_scene"], true);
  EXPECT_EQ(table["cut"]["has_base"], true);
  EXPECT_NEAR(table["turns"].get<double>(), 47.0 / 48, 0.01);
  EXPECT_LT(table["rms_m"].get<double>(), 0.5e-3);
}

TEST_F(Tower, HasAnglesThatAreRight) {
  std::ifstream log(recording() + "/true_poses.log");
  std::vector<double> cosines;  // of the turn from the first frame, from the true rotations
  double first[9] = {};
  for (std::string line; std::getline(log, line);) {  // three integers, then four rows
    double m[16];
    for (double& value : m) log >> value;
    std::getline(log, line);
    const double r[9] = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
    if (cosines.empty()) std::copy(r, r + 9, first);
    double trace = 0;
    for (int i = 0; i < 9; ++i) trace += first[i] * r[i];
    cosines.push_back((trace - 1) / 2);
  }
  const Json angles = report(place("found"))["turntable"]["angles"];
  ASSERT_GE(angles.size(), 47u);
  for (const Json& angle : angles) {
    const double found = angle["degrees"].get<double>() * 3.14159265358979 / 180;
    const double truth = std::acos(std::clamp(cosines.at(angle["frame"].get<std::size_t>()), -1.0, 1.0));
    EXPECT_LT(std::abs(std::remainder(std::acos(std::cos(found)) - truth, 6.283185307)), 0.006)
        << angle;  // 0.35 degrees
  }
}

TEST_F(Tower, LeavesARecordingOfItselfAlone) {
  const Outcome run = scanknit_command({"run", place("cut"), "-o", place("of_cut"), "--set", "fusion.voxel_size=2mm",
                                        "--set", "extract.min_component_triangles=0", "--quiet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json cut = report(place("of_cut"));
  EXPECT_TRUE(cut["tracking"].is_null());  // it has poses
  EXPECT_EQ(cut["frames"]["fused"], report(place("found"))["frames"]["fused"]);
  for (int end : {0, 1}) {  // no disc below, no wall, no hand
    for (int axis : {0, 1, 2}) {
      const double whole = report(place("found"))["mesh"]["bounds_m"][end][axis].get<double>();
      EXPECT_NEAR(cut["mesh"]["bounds_m"][end][axis].get<double>(), whole, 0.010);
    }
  }
}

TEST_F(Tower, IsTheSameForAnyNumberOfThreads) {
  std::vector<std::string> meshes;
  for (const char* threads : {"1", "2", "8"}) {
    const std::string mesh = place(std::string("threads") + threads + ".ply");
    ASSERT_EQ(scan(recording(), mesh, {"--threads", threads, "--every", "2"}).exit_code, 0);
    meshes.push_back(read_text(mesh));
  }
  EXPECT_EQ(meshes[0], meshes[1]);
  EXPECT_EQ(meshes[0], meshes[2]);
}

TEST_F(Tower, IsClosedAllRoundByASecondTurnOnItsSide) {
  const Outcome synth =
      scanknit_command({"synth", "tower", "--turntable", "--on-side", "--angle-noise", "0.5", "--noise", "--seed", "2",
                        "-o", place("side"), "--frames", "48", "--width", "240", "--height", "180", "--quiet"});
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  ASSERT_EQ(scan(place("side"), place("of_side"), {"--cut-recording", place("side_cut")}).exit_code, 0);
  const Outcome joined = scanknit_command({"align", place("cut"), place("side_cut"), "-o", place("joined"), "--set",
                                           "fusion.voxel_size=2mm", "--set", "finish.watertight=full", "--quiet"});
  ASSERT_EQ(joined.exit_code, 0) << joined.err;
  const Json both = report(place("joined"));
  EXPECT_EQ(both["alignment"]["pairs"][0]["verdict"], "good");
  EXPECT_EQ(both["mesh"]["is_closed"], true);
  EXPECT_EQ(both["mesh"]["euler"], 2);
  EXPECT_EQ(both["mesh"]["components"], 1);
  // Little is invented: the rim that lay on the disc both times. The rest of the underside was seen.
  const Json& closed = both["finish"]["steps"][0];
  EXPECT_EQ(closed["name"], "watertight");
  EXPECT_LT(closed["figures"]["invented_share"], 0.03);
  // The world is that of the first turn.
  const Outcome distance = scanknit_command({"distance", place("joined") + "/model.ply", recording(), "--trajectory",
                                             place("found") + "/trajectory.txt", "--json"});
  ASSERT_EQ(distance.exit_code, 0) << distance.err;
  EXPECT_LE(Json::parse(distance.out)["area"]["mean_m"].get<double>(), 1.5 * 0.188e-3) << "of one turn with true poses";
}

TEST_F(Tower, TakesAnglesFromAFileAndSaysWhatIsWrongWithIt) {
  ASSERT_EQ(scan(recording(), place("encoder"), {"--angles", recording() + "/angles.txt"}).exit_code, 0);
  EXPECT_EQ(report(place("encoder"))["turntable"]["prior"], "file");
  EXPECT_LE(mean_error_m(place("encoder")), 0.4e-3);

  std::ofstream(place("short.txt")) << "# degrees\n0\n7.5\n";
  const Outcome too_short = scan(recording(), place("x"), {"--angles", place("short.txt")});
  EXPECT_EQ(too_short.exit_code, 3);
  EXPECT_NE(too_short.err.find("has 2 angles"), std::string::npos) << too_short.err;
  std::ofstream(place("bad.txt")) << "0\nseven\n";
  const Outcome bad = scan(recording(), place("y"), {"--angles", place("bad.txt")});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_NE(bad.err.find("bad.txt:2: expected an angle in degrees, got 'seven'"), std::string::npos) << bad.err;
}

TEST_F(Tower, TakesAStepFromFrameToFrame) {
  ASSERT_EQ(scan(recording(), place("step"), {"--set", "turntable.step=7.5"}).exit_code, 0);
  EXPECT_EQ(report(place("step"))["turntable"]["prior"], "step");
  EXPECT_EQ(report(place("step"))["turntable"]["is_refined"], true);
  EXPECT_LE(mean_error_m(place("step")), 0.4e-3);
  ASSERT_EQ(scan(recording(), place("wrong_step"), {"--set", "turntable.step=7"}).exit_code, 0);
  EXPECT_LE(mean_error_m(place("wrong_step")), 0.4e-3);  // the pictures decide
  const Json wrong = report(place("wrong_step"));
  EXPECT_EQ(wrong["turntable"]["prior"], "none");
  double seen_degrees = 0;
  const std::string warning = wrong["warnings"].at(0).get<std::string>();
  ASSERT_EQ(std::sscanf(warning.c_str(), "turntable.step is 7 degrees, but the pictures turn by %lf", &seen_degrees), 1)
      << warning;
  EXPECT_NEAR(seen_degrees, 7.5, 0.05);
  const Outcome no_times = scan(recording(), place("rpm"), {"--set", "turntable.rpm=2"});
  EXPECT_EQ(no_times.exit_code, 3);
  EXPECT_NE(no_times.err.find("no times; give turntable.step"), std::string::npos) << no_times.err;
}

TEST_F(Tower, WithAGapIsThePartThatHoldsTogetherUnlessAnglesJoinIt) {
  const std::string gap = place("gap");  // of 83 degrees: nothing that is seen before it is seen after it
  copy_frames(recording(), gap, {{0, 15}, {25, 48}});
  const Outcome part = scan(gap, place("part"));
  ASSERT_EQ(part.exit_code, 0) << part.err;
  EXPECT_TRUE(has_warning(place("part"), "only 23 of 38 frames fit together; frames 0 to 14 are left out"));
  EXPECT_LE(mean_error_m(place("part"), gap), 0.4e-3);
  const Outcome stepped = scan(gap, place("stepped"), {"--set", "turntable.step=7.5"});  // knows nothing of the gap
  ASSERT_EQ(stepped.exit_code, 0) << stepped.err;
  EXPECT_TRUE(has_warning(place("stepped"), "only 23 of 38 frames fit together"));
  EXPECT_TRUE(has_warning(place("stepped"), "turntable.step is not used"));
  EXPECT_EQ(report(place("stepped"))["turntable"]["is_closed"], false);  // the part is half a turn
  EXPECT_LE(mean_error_m(place("stepped"), gap), 0.4e-3);
  const Outcome joined = scan(gap, place("joined"), {"--angles", gap + "/angles.txt"});
  ASSERT_EQ(joined.exit_code, 0) << joined.err;
  EXPECT_TRUE(has_warning(place("joined"), "frames 0 to 14 are joined to the rest by the angle file alone"));
  EXPECT_EQ(report(place("joined"))["frames"]["fused"], 38);
  EXPECT_LE(mean_error_m(place("joined"), gap), 0.4e-3);
}

TEST_F(Tower, InterruptedWhileLostFramesArePutRightIsMeshedAsTracked) {
  const std::string lost = place("lost");
  copy_frames(recording(), lost, {{0, 36}});
  for (int frame = 12; frame < 24; ++frame) {  // ninety degrees: the rest is not recognised
    cv::imwrite(lost + "/depth/" + picture_name(frame), cv::Mat::zeros(180, 240, CV_16U));
  }
  Program program({"run", lost, "--preset", "turntable", "-o", place("stopped"), "--set", "fusion.voxel_size=2mm"});
  while (program.is_running() && program.err_so_far().find("registering") == std::string::npos) {
    std::this_thread::yield();
  }
  program.send(SIGINT);
  const Outcome outcome = program.wait();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_TRUE(fs::exists(place("stopped") + "/model.ply"));
  EXPECT_TRUE(has_warning(place("stopped"), "no turntable: it was interrupted; the mesh is the tracked one"));
  EXPECT_TRUE(has_warning(place("stopped"), "tracking was lost in 24 of 36 frames"));
  EXPECT_FALSE(has_warning(place("stopped"), "found again"));
}

TEST_F(Tower, TakesForTheFrameOfAMistypedAngleWhatIsSeen) {
  std::vector<std::string> angles = lines_of(recording() + "/angles.txt");
  angles.at(5) = "7000";
  std::ofstream typed(place("typed.txt"));
  for (const std::string& angle : angles) typed << angle << '\n';
  typed.close();
  const Outcome run = scan(recording(), place("typed"), {"--angles", place("typed.txt")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(has_warning(place("typed"), "the angle of frame 5 (7000 degrees); the angles in the pictures are used"));
  EXPECT_LE(mean_error_m(place("typed")), 0.4e-3);
  EXPECT_LT(report(place("typed"))["turntable"]["turns"].get<double>(), 1.1);
}

TEST_F(Tower, WarnsThatStillPosesExcludeATurntable) {
  ASSERT_EQ(scan(recording(), place("still"), {"--poses", "still"}).exit_code, 0);
  EXPECT_TRUE(has_warning(place("still"), "acquire.poses is still: nothing turns"));
}

TEST_F(Tower, PutsItsCutRecordingOnlyWhereNothingIs) {
  const auto refused = [](const Outcome& run, int exit_code, const char* message) {
    EXPECT_EQ(run.exit_code, exit_code);
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(place("nothing")));
  };
  const std::string out = place("nothing");
  refused(scan(recording(), out, {"--cut-recording", recording()}), 8, "lies in the recording itself");
  refused(scan(recording(), out, {"--cut-recording", recording() + "/turn"}), 8, "lies in the recording itself");
  refused(scan(recording(), out, {"--cut-recording", place("cut")}), 8, "is there already and not an empty folder");
  for (const char* spelling : {"", "/", "/.", "/x/.."}) {
    refused(scan(recording(), out, {"--cut-recording", out + spelling}), 8, "is where the mesh goes");
  }
  refused(scanknit_command({"run", recording(), "-o", out, "--cut-recording", place("other")}), 2,
          "set turntable.enabled");
  EXPECT_FALSE(fs::exists(recording() + "/trajectory.log"));
}

TEST_F(Tower, WantsAnAngleForEveryFrameBeforeAnyWork) {
  const std::string out = place("no_angles");
  const auto refused = [&](const std::vector<std::string>& more, const char* message) {
    const Outcome run = scan(recording(), out, more);
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(fs::path(out) / "model.ply"));
  };
  std::ofstream(place("blank.txt")) << "# degrees\n0\n\n7.5\n";
  refused({"--angles", place("blank.txt")}, "blank.txt:3: an empty line");
  std::ofstream(place("few.txt")) << "0\n7.5\n\n";
  refused({"--angles", place("few.txt")}, "has 2 angles, but there is a frame 47");
  refused({"--set", "turntable.rpm=2"}, "no times; give turntable.step");
  refused({"--set", "turntable.step=-7.5"}, "the sign is not needed, either direction is found: write 7.5");
}

/// What is no turntable is meshed as if the preset knew of none.
void expect_left_alone(const std::vector<std::string>& scene, const char* last_frame, const std::string& reason) {
  const TempFolder folder;
  const std::string recording = folder / "recording";
  std::vector<std::string> synth = {"synth", "-o", recording, "--width", "160", "--height", "120", "--quiet"};
  synth.insert(synth.end(), scene.begin(), scene.end());
  ASSERT_EQ(scanknit_command(synth).exit_code, 0);
  const auto run = [&](const char* is_enabled) {
    const std::string mesh = folder / (std::string(is_enabled) + ".ply");
    const Outcome done =
        scanknit_command({"run", recording, "--preset", "turntable", "--poses", "track", "-o", mesh, "--set",
                          "acquire.max_depth=0", "--set", "fusion.voxel_size=1cm", "--to", last_frame, "--set",
                          std::string("turntable.enabled=") + is_enabled, "--json"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    if (std::string(is_enabled) == "true") {
      const Json table = Json::parse(done.out)["turntable"];
      EXPECT_EQ(table["is_refined"], false);
      EXPECT_EQ(table["reason"], reason);
      EXPECT_NE(done.err.find("no turntable: " + reason), std::string::npos) << done.err;
    }
    return read_text(mesh);
  };
  EXPECT_EQ(run("true"), run("false"));
}

TEST(NoTurntable, AWalkRoundADeskIsLeftAsItWasTracked) {
  expect_left_alone({"desk", "--frames", "90"}, "49", "the scanner moves, not the object");
}

TEST(NoTurntable, AWalkRoundAnObjectAtAllHeightsIsLeftAsItWasTracked) {
  expect_left_alone({"turntable", "--frames", "180"}, "179", "the motion is not about one axis");
}

}  // namespace
}  // namespace scanknit
