// Jobs whose poses are tracked, or from a file.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/app/program.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kOrbitFrames = 120;  // 3 degrees and 5 cm from frame to frame

/// A recording of the desk whose poses lie beside it, in trajectory.log: sixteen numbers after each line of three.
class JobPoses : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    original_ = new TempFolder;
    const Outcome synth =
        scanknit_command({"synth", "desk", "-o", *original_ / "recording", "--frames", std::to_string(kOrbitFrames),
                          "--width", "160", "--height", "120", "--quiet"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
    fs::rename(*original_ / "recording/trajectory.log", *original_ / "trajectory.log");
  }
  static void TearDownTestSuite() {
    delete original_;
    original_ = nullptr;
  }
  void SetUp() override { fs::copy(*original_ / "recording", recording(), fs::copy_options::recursive); }

  [[nodiscard]] fs::path recording() const { return folder_ / "recording"; }
  [[nodiscard]] std::string job() const { return folder_ / "job"; }
  void give_poses() const { fs::copy(*original_ / "trajectory.log", recording()); }
  void take_poses() const { fs::remove(recording() / "trajectory.log"); }

  [[nodiscard]] static Outcome command(std::vector<std::string> arguments, const std::vector<std::string>& more = {}) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  [[nodiscard]] Json report(const std::string& name) const {
    return Json::parse(read_text(fs::path(folder_ / name) / "report.json"));
  }

  void run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"run", recording(), "-o", folder_ / "run", "--set", "fusion.voxel_size=2cm"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome ran = command(arguments);
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
  }
  void plan_work_and_join(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"plan",  recording(),       "-o", job(), "--set", "fusion.voxel_size=2cm",
                                          "--set", "fusion.bricks=64"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome planned = command(arguments);
    ASSERT_EQ(planned.exit_code, 0) << planned.err;
    ASSERT_EQ(command({"work", job(), "--workers", "2"}).exit_code, 0);
    const Outcome joined = command({"join", job(), "-o", folder_ / "joined"});
    ASSERT_EQ(joined.exit_code, 0) << joined.err;
    ASSERT_GT(Json::parse(command({"status", job(), "--json"}).out)["bricks"], 4);
  }
  void expect_same_files() const {
    for (const char* name : {"model.glb", "model.ply", "preview.png", "trajectory.txt", "error.png", "coverage.png"}) {
      const fs::path path = fs::path(folder_ / "run") / name;
      if (!fs::exists(path)) continue;
      EXPECT_EQ(read_text(fs::path(folder_ / "joined") / name), read_text(path)) << name << " bit by bit";
    }
  }

  /// The numbers of trajectory.log, twelve of each pose.
  [[nodiscard]] static std::vector<std::vector<std::string>> logged_poses() {
    std::ifstream log(*original_ / "trajectory.log");
    std::vector<std::vector<std::string>> poses;
    std::string line;
    while (std::getline(log, line)) {
      std::vector<std::string> numbers(12);
      for (std::string& number : numbers) log >> number;
      for (int i = 0; i < 2; ++i) std::getline(log, line);  // the rest of the third row, and 0 0 0 1
      poses.push_back(std::move(numbers));
    }
    return poses;
  }
  void write_kitti(const fs::path& path, std::size_t count) const {
    std::ofstream file(path);
    const auto logged = logged_poses();
    for (std::size_t i = 0; i < count; ++i) {
      for (const std::string& number : logged[i]) file << number << ' ';
      file << '\n';
    }
  }

  static TempFolder* original_;
  TempFolder folder_;
};

TempFolder* JobPoses::original_ = nullptr;

TEST_F(JobPoses, ThatAreTrackedGiveTheFilesOfRun) {
  ASSERT_NO_FATAL_FAILURE(run());
  ASSERT_NO_FATAL_FAILURE(plan_work_and_join());
  expect_same_files();
  for (const char* part : {"frames", "tracking", "volume"}) EXPECT_EQ(report("joined")[part], report("run")[part]);
  EXPECT_EQ(report("joined")["tracking"]["states"]["ok"], kOrbitFrames);
}

TEST_F(JobPoses, ThatWereFoundLaterGiveTheFilesOfRun) {
  for (int frame = 40; frame < 80; ++frame) {
    std::string name = "0000" + std::to_string(frame) + ".png";
    fs::remove(recording() / "depth" / name);
    fs::remove(recording() / "color" / name);
  }
  ASSERT_NO_FATAL_FAILURE(run());
  EXPECT_GT(report("run")["tracking"]["found_later"], 0);
  ASSERT_NO_FATAL_FAILURE(plan_work_and_join());
  expect_same_files();
  for (const char* part : {"frames", "tracking", "volume"}) EXPECT_EQ(report("joined")[part], report("run")[part]);
}

TEST_F(JobPoses, ThatAreRefinedGiveTheFilesOfRun) {
  give_poses();
  ASSERT_NO_FATAL_FAILURE(run({"--poses", "refine"}));
  ASSERT_NO_FATAL_FAILURE(plan_work_and_join({"--poses", "refine"}));
  expect_same_files();
  EXPECT_EQ(report("joined")["tracking"]["mode"], "refine");
}

TEST_F(JobPoses, OfAFileAreThoseOfTheRecordingThatHasThem) {
  give_poses();
  ASSERT_NO_FATAL_FAILURE(run());
  take_poses();
  write_kitti(folder_ / "poses.kitti", kOrbitFrames);
  Json json = {{"poses", Json::array()}};
  const auto logged = logged_poses();
  for (std::size_t i = 0; i < logged.size(); ++i) {
    Json rows = Json::array({Json::array(), Json::array(), Json::array(), {0.0, 0.0, 0.0, 1.0}});
    for (std::size_t k = 0; k < 12; ++k) rows[k / 4].push_back(std::stod(logged[i][k]));
    json["poses"].push_back({{"stamp", i}, {"T_world_camera", rows}});
  }
  std::ofstream(folder_ / "poses.json") << json.dump();
  for (const char* file : {"poses.kitti", "poses.json"}) {
    fs::remove_all(job());
    fs::remove_all(folder_ / "joined");
    ASSERT_NO_FATAL_FAILURE(plan_work_and_join({"--trajectory", folder_ / file}));
    expect_same_files();
    EXPECT_EQ(report("joined")["frames"], report("run")["frames"]);
  }
}

TEST_F(JobPoses, OfATumFileAreTakenByTheirTimes) {
  give_poses();
  const fs::path tum = folder_ / "tum";
  ASSERT_EQ(command({"convert", recording(), "-o", tum, "--to", "tum"}).exit_code, 0);
  fs::remove_all(recording());
  fs::rename(tum, recording());
  ASSERT_NO_FATAL_FAILURE(run());
  fs::rename(recording() / "groundtruth.txt", folder_ / "poses.txt");
  ASSERT_NO_FATAL_FAILURE(plan_work_and_join({"--trajectory", folder_ / "poses.txt"}));
  expect_same_files();
}

TEST_F(JobPoses, OfAFileThatDoesNotFitAreRefused) {
  write_kitti(folder_ / "short.kitti", kOrbitFrames - 1);
  std::ofstream(folder_ / "other.json") << "{\"poses\": [{\"stamp\": 1}]}";
  std::ofstream(folder_ / "empty.txt") << "# nothing\n";
  for (const char* file : {"short.kitti", "other.json", "empty.txt", "nowhere.txt"}) {
    const Outcome planned = command({"plan", recording(), "-o", job(), "--trajectory", folder_ / file});
    EXPECT_EQ(planned.exit_code, 4) << file << planned.err;
    EXPECT_NE(planned.err.find(file), std::string::npos) << planned.err;
    EXPECT_FALSE(fs::exists(job()));
  }
}

TEST_F(JobPoses, ThatAFileLacksDropTheirFrames) {
  std::ofstream file(folder_ / "some.txt");
  for (int i = 10; i < 30; ++i) file << i << " 0 0 0 0 0 0 1\n";
  file.close();
  ASSERT_NO_FATAL_FAILURE(plan_work_and_join({"--trajectory", folder_ / "some.txt"}));
  EXPECT_EQ(report("joined")["frames"]["fused"], 20);
  EXPECT_EQ(report("joined")["frames"]["dropped_by_reason"]["no_pose"], kOrbitFrames - 20);
}

}  // namespace
}  // namespace scanknit
