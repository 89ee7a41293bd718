// A recording that several processes scan gives the files that one process gives.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <thread>

#include "tests/app/scan.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::vector<std::string> kSettings = {"--set", "fusion.voxel_size=4mm", "--set", "fusion.bricks=64"};

std::map<std::string, std::string> brick_files(const fs::path& job) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(job / "bricks")) {
    if (entry.path().extension() == ".brick") files[entry.path().filename()] = read_text(entry.path());
  }
  return files;
}

/// As if its workers had died long ago.
void age_claims(const fs::path& job) {
  for (const auto& entry : fs::directory_iterator(job / "claims")) {
    fs::last_write_time(entry.path(), fs::last_write_time(entry.path()) - std::chrono::hours(1));
  }
}

class Jobs : public ::testing::Test {
 protected:
  [[nodiscard]] static Outcome command(std::vector<std::string> arguments, const std::vector<std::string>& more = {}) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  void plan(const std::vector<std::string>& settings = kSettings) const {
    const Outcome planned = command({"plan", scan_.recording().string(), "-o", job()}, settings);
    ASSERT_EQ(planned.exit_code, 0) << planned.err;
  }
  void work() const {
    const Outcome worked = command({"work", job()});
    ASSERT_EQ(worked.exit_code, 0) << worked.err;
  }
  [[nodiscard]] Json status() const { return Json::parse(command({"status", job(), "--json"}).out); }
  [[nodiscard]] std::string job() const { return (scan_ / "job").string(); }
  [[nodiscard]] fs::path brick(int number) const {
    return scan_ / "job" / "bricks" / (std::to_string(number) + ".brick");
  }

  /// Joins the job and expects the files of `scanknit run`.
  void expect_files_of_run(const std::vector<std::string>& settings = kSettings) const {
    const fs::path run = scan_ / "run", joined = scan_ / "joined";
    const Outcome ran = command({"run", scan_.recording().string(), "-o", run.string()}, settings);
    ASSERT_EQ(ran.exit_code, 0) << ran.err;
    const Outcome outcome = command({"join", job(), "-o", joined.string()});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    std::size_t compared = 0;
    for (const auto& entry : fs::directory_iterator(run)) {
      const std::string name = entry.path().filename();
      ASSERT_TRUE(fs::exists(joined / name)) << name;
      if (name.starts_with("report.")) continue;  // has times
      EXPECT_EQ(read_text(joined / name), read_text(run / name)) << name << " bit by bit";
      ++compared;
    }
    EXPECT_GE(compared, 3u);
    expect_same_report(Json::parse(read_text(run / "report.json")), Json::parse(read_text(joined / "report.json")));
  }

  static void expect_same_report(const Json& run, const Json& joined) {
    for (const char* part : {"frames", "volume", "config"}) EXPECT_EQ(joined[part], run[part]) << part;
    EXPECT_EQ(joined["mesh"]["triangles"], run["mesh"]["triangles"]);
  }

  Scan scan_{{.frames = 24, .width = 160, .height = 120}};
};

class JobsInBricks : public Jobs, public ::testing::WithParamInterface<int> {};

TEST_P(JobsInBricks, GiveTheFilesOfRun) {
  const std::vector<std::string> settings = {"--set", "fusion.voxel_size=4mm", "--set",
                                             "fusion.bricks=" + std::to_string(GetParam())};
  ASSERT_NO_FATAL_FAILURE(plan(settings));
  const Json planned = status();
  ASSERT_GT(planned["bricks"], 1);
  EXPECT_EQ(planned["free"], planned["bricks"]);
  {
    Program one({"work", job()}), two({"work", job()});
    EXPECT_EQ(one.wait().exit_code, 0);
    EXPECT_EQ(two.wait().exit_code, 0);
  }
  EXPECT_EQ(status()["done"], planned["bricks"]);
  EXPECT_TRUE(fs::is_empty(scan_ / "job" / "claims"));
  expect_files_of_run(settings);
}

INSTANTIATE_TEST_SUITE_P(Voxels, JobsInBricks, ::testing::Values(64, 128), ::testing::PrintToStringParamName());

TEST_F(Jobs, GoOnAfterAWorkerWasKilled) {
  ASSERT_NO_FATAL_FAILURE(plan());
  Program worker({"work", job()});
  while (worker.is_running() && !fs::exists(brick(0))) std::this_thread::yield();
  worker.send(SIGKILL);
  EXPECT_EQ(worker.wait().exit_code, 128 + SIGKILL);
  age_claims(scan_ / "job");
  ASSERT_NO_FATAL_FAILURE(work());
  expect_files_of_run();
}

TEST_F(Jobs, AnyWorkerMakesTheSameBytes) {
  ASSERT_NO_FATAL_FAILURE(plan());
  ASSERT_NO_FATAL_FAILURE(work());
  const auto first = brick_files(scan_ / "job");
  ASSERT_EQ(first.size(), status()["bricks"]);
  for (const auto& [name, bytes] : first) fs::remove(scan_ / "job" / "bricks" / name);
  for (std::size_t i = first.size(); i > 0; --i) {
    ASSERT_EQ(command({"work", job(), "--brick", std::to_string(i - 1), "--threads", "1"}).exit_code, 0);
  }
  EXPECT_EQ(brick_files(scan_ / "job"), first);
}

TEST_F(Jobs, SeveralBricksAtOnceAreTheSameBytes) {
  ASSERT_NO_FATAL_FAILURE(plan());
  ASSERT_NO_FATAL_FAILURE(work());
  const auto one_by_one = brick_files(scan_ / "job");
  for (const auto& [name, bytes] : one_by_one) fs::remove(scan_ / "job" / "bricks" / name);
  ASSERT_EQ(command({"work", job(), "--workers", "1"}).exit_code, 0);
  EXPECT_EQ(brick_files(scan_ / "job"), one_by_one);
}

TEST_F(Jobs, LocalWorkersDoAllOfIt) {
  ASSERT_NO_FATAL_FAILURE(plan());
  const Outcome worked = command({"work", job(), "--local", "2", "--json"});
  ASSERT_EQ(worked.exit_code, 0) << worked.err;
  EXPECT_EQ(Json::parse(worked.out)["fused"], status()["bricks"]);
  EXPECT_TRUE(fs::is_empty(scan_ / "job" / "claims"));
  expect_files_of_run();
}

TEST_F(Jobs, WhatALocalWorkerSaysIsTold) {
  ASSERT_NO_FATAL_FAILURE(plan());
  fs::rename(scan_.recording(), scan_ / "elsewhere");
  const Outcome worked = command({"work", job(), "--local", "2", "--quiet"});
  EXPECT_EQ(worked.exit_code, 4);
  for (const char* worker : {"worker 1: ", "worker 2: ", "worker 1 ended with exit code 4"}) {
    EXPECT_NE(worked.err.find(worker), std::string::npos) << worked.err;
  }
}

/// Waits until workers are at bricks.
void wait_for_claims(const fs::path& job, Program& program) {
  while (program.is_running() && fs::is_empty(job / "claims")) std::this_thread::yield();
}

TEST_F(Jobs, AStopEndsLocalWorkersAndFreesTheirBricks) {
  for (const int signal : {SIGTERM, SIGINT}) {
    fs::remove_all(scan_ / "job");
    ASSERT_NO_FATAL_FAILURE(plan());
    Program program({"work", job(), "--local", "2"});
    wait_for_claims(scan_ / "job", program);
    program.send(signal);
    const Outcome stopped = program.wait();
    EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
    EXPECT_TRUE(fs::is_empty(scan_ / "job" / "claims"));
  }
  ASSERT_NO_FATAL_FAILURE(work());
  expect_files_of_run();
}

TEST_F(Jobs, LocalWorkersEndWithAParentThatWasKilled) {
  ASSERT_NO_FATAL_FAILURE(plan());
  Program program({"work", job(), "--local", "2"});
  wait_for_claims(scan_ / "job", program);
  program.send(SIGKILL);
  EXPECT_EQ(program.wait().exit_code, 128 + SIGKILL);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!fs::is_empty(scan_ / "job" / "claims") && std::chrono::steady_clock::now() < patience) {
    std::this_thread::yield();
  }
  EXPECT_TRUE(fs::is_empty(scan_ / "job" / "claims"));
  ASSERT_NO_FATAL_FAILURE(work());
  expect_files_of_run();
}

/// Kills a command after some parts of the time that it takes.
template <typename AfterKill>
void kill_at_times(const std::vector<std::string>& arguments, std::chrono::steady_clock::duration takes,
                   const AfterKill& after) {
  constexpr int kTimes = 6;
  for (int i = 1; i <= kTimes; ++i) {
    Program program(arguments);
    const auto until = std::chrono::steady_clock::now() + i * takes / kTimes;
    while (program.is_running() && std::chrono::steady_clock::now() < until) std::this_thread::yield();
    if (program.is_running()) program.send(SIGKILL);
    (void)program.wait();
    ASSERT_NO_FATAL_FAILURE(after());
  }
}

TEST_F(Jobs, APlanThatIsKilledLeavesAWholeJobOrNone) {
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_NO_FATAL_FAILURE(plan());
  const auto takes = std::chrono::steady_clock::now() - begin;
  const std::string whole = read_text(scan_ / "job" / "plan");
  fs::remove_all(scan_ / "job");
  std::vector<std::string> arguments = {"plan", scan_.recording().string(), "-o", job()};
  arguments.insert(arguments.end(), kSettings.begin(), kSettings.end());
  kill_at_times(arguments, takes, [&] {
    if (!fs::exists(scan_ / "job")) return;
    EXPECT_EQ(read_text(scan_ / "job" / "plan"), whole);
    EXPECT_EQ(command({"status", job()}).exit_code, 0);
    fs::remove_all(scan_ / "job");
  });
  ASSERT_NO_FATAL_FAILURE(plan());
  EXPECT_EQ(read_text(scan_ / "job" / "plan"), whole);
}

TEST_F(Jobs, AJoinThatIsKilledLeavesWholeFilesOrNone) {
  ASSERT_NO_FATAL_FAILURE(plan());
  ASSERT_NO_FATAL_FAILURE(work());
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_EQ(command({"join", job(), "-o", (scan_ / "whole").string()}).exit_code, 0);
  const auto takes = std::chrono::steady_clock::now() - begin;
  kill_at_times({"join", job(), "-o", (scan_ / "joined").string()}, takes, [&] {
    for (const char* name : {"model.ply", "model.glb", "trajectory.txt"}) {
      if (!fs::exists(scan_ / "joined" / name)) continue;
      EXPECT_EQ(read_text(scan_ / "joined" / name), read_text(scan_ / "whole" / name)) << name;
    }
    fs::remove_all(scan_ / "joined");
  });
  expect_files_of_run();
}

TEST_F(Jobs, AnEstimateSaysWhatTheJobTakesAndLeavesItAsItWas) {
  std::vector<std::string> arguments = {
      "plan", scan_.recording().string(), "-o", job(), "--estimate", "--workers", "2", "--json"};
  const Outcome planned = command(arguments, kSettings);
  ASSERT_EQ(planned.exit_code, 0) << planned.err;
  const Json estimate = Json::parse(planned.out)["estimate"];
  const Json file = Json::parse(read_text(scan_ / "job" / "estimate.json"));
  EXPECT_EQ(estimate["workers"], 2);
  EXPECT_EQ(estimate["frames"], 24);
  EXPECT_EQ(estimate["bricks"], status()["bricks"]);
  EXPECT_EQ(file["each_brick"].size(), status()["bricks"]);
  for (const char* step : {"plan", "work", "join"}) EXPECT_GT(estimate["processor_s"][step], 0) << step;
  for (const char* figure : {"wall_s", "worker_mib", "join_mib", "job_mib", "triangles"}) {
    EXPECT_GT(estimate[figure], 0) << figure;
  }
  for (const char* part : {"frame", "brick", "seam"}) EXPECT_GT(estimate[part]["bytes"], 0) << part;
  EXPECT_LT(estimate["wall_s"], estimate["processor_s"]["all"]) << "two work at once";
  EXPECT_EQ(status()["done"], 0);
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(scan_ / "job")) ++entries;
  EXPECT_EQ(entries, 5u) << "plan, config.yaml, estimate.json, bricks, claims";
  ASSERT_NO_FATAL_FAILURE(work());
  std::uintmax_t bytes = 0;
  for (const auto& [name, brick] : brick_files(scan_ / "job")) bytes += brick.size();
  constexpr double kWithin = 3;  // three of a few small bricks were looked at
  const double expected = estimate["job_mib"].get<double>() * 1024 * 1024;
  EXPECT_LT(static_cast<double>(bytes), kWithin * expected);
  EXPECT_GT(static_cast<double>(bytes), expected / kWithin);
  expect_files_of_run();
}

TEST_F(Jobs, ABrickThatALivingWorkerIsAtIsLeftToIt) {
  ASSERT_NO_FATAL_FAILURE(plan());
  const fs::path claim = scan_ / "job" / "claims" / "0.claim";
  std::ofstream(claim) << "another machine\n";
  ASSERT_NO_FATAL_FAILURE(work());
  EXPECT_FALSE(fs::exists(brick(0)));
  EXPECT_EQ(status()["in_work"], 1);
  const Outcome early = command({"join", job(), "-o", (scan_ / "early").string()});
  EXPECT_EQ(early.exit_code, 4);
  EXPECT_NE(early.err.find("1 of "), std::string::npos) << early.err;
  EXPECT_NE(early.err.find("scanknit work "), std::string::npos) << early.err;
  EXPECT_FALSE(fs::exists(scan_ / "early" / "model.glb"));
  age_claims(scan_ / "job");
  EXPECT_EQ(status()["in_work"], 0);
  ASSERT_NO_FATAL_FAILURE(work());
  EXPECT_EQ(status()["done"], status()["bricks"]);
}

TEST_F(Jobs, ATornBrickIsMadeAnew) {
  ASSERT_NO_FATAL_FAILURE(plan());
  ASSERT_NO_FATAL_FAILURE(work());
  const std::string whole = read_text(brick(1));
  fs::resize_file(brick(1), whole.size() / 2);
  EXPECT_EQ(status()["done"], status()["bricks"]) << "by the names alone";
  const Json checked = Json::parse(command({"status", job(), "--check", "--json"}).out);
  EXPECT_EQ(checked["torn"], 1);
  EXPECT_EQ(checked["done"].get<int>() + 1, checked["bricks"]);
  ASSERT_NO_FATAL_FAILURE(work());
  EXPECT_EQ(read_text(brick(1)), whole);
}

TEST_F(Jobs, ADamagedBrickIsNamedAndMadeAnew) {
  ASSERT_NO_FATAL_FAILURE(plan());
  ASSERT_NO_FATAL_FAILURE(work());
  const std::string whole = read_text(brick(0));
  std::fstream(brick(0), std::ios::in | std::ios::out | std::ios::binary)
      .seekp(900)
      .put('\x5a')
      .put('\x17')
      .put('\x2b');
  const Outcome joined = command({"join", job(), "-o", (scan_ / "out.ply").string()});
  EXPECT_EQ(joined.exit_code, 4);
  EXPECT_NE(joined.err.find("--brick 0"), std::string::npos) << joined.err;
  ASSERT_EQ(command({"work", job(), "--brick", "0"}).exit_code, 0);
  EXPECT_EQ(read_text(brick(0)), whole);
}

TEST_F(Jobs, AnInputThatHasChangedIsRefused) {
  ASSERT_NO_FATAL_FAILURE(plan());
  const fs::path other = scan_ / "other";
  ASSERT_EQ(
      command({"synth", "desk", "-o", other.string(), "--frames", "1", "--width", "160", "--height", "120"}).exit_code,
      0);
  const fs::path picture = fs::directory_iterator(other / "depth")->path();
  fs::copy_file(picture, scan_.depth_picture(2), fs::copy_options::overwrite_existing);
  const Outcome worked = command({"work", job()});
  EXPECT_EQ(worked.exit_code, 4);
  EXPECT_NE(worked.err.find("has changed since it was planned"), std::string::npos) << worked.err;
  EXPECT_LT(status()["done"], status()["bricks"]);
}

TEST_F(Jobs, AnotherConfigurationIsRefused) {
  ASSERT_NO_FATAL_FAILURE(plan());
  EXPECT_EQ(command({"work", job(), "--set", "fusion.voxel_size=5mm"}).exit_code, 2);
  std::ofstream(scan_ / "job" / "config.yaml", std::ios::app) << "# edited\n";
  const Outcome worked = command({"work", job()});
  EXPECT_EQ(worked.exit_code, 3);
  EXPECT_NE(worked.err.find("was changed since the job was planned"), std::string::npos) << worked.err;
}

TEST_F(Jobs, TheFolderMayBeMoved) {
  ASSERT_NO_FATAL_FAILURE(plan());
  fs::create_directories(scan_ / "there" / "deeper");
  fs::rename(scan_ / "job", scan_ / "there" / "deeper" / "job");
  const std::string moved = (scan_ / "there" / "deeper" / "job").string();
  EXPECT_EQ(command({"work", moved}).exit_code, 0);
  fs::rename(moved, scan_ / "job");
  expect_files_of_run();
}

TEST_F(Jobs, TheFolderAndTheRecordingMayBeMovedTogether) {
  ASSERT_NO_FATAL_FAILURE(plan());
  fs::create_directories(scan_ / "there");
  fs::rename(scan_ / "job", scan_ / "there" / "job");
  fs::rename(scan_.recording(), scan_ / "there" / "recording");
  const std::string moved = (scan_ / "there" / "job").string();
  const Outcome worked = command({"work", moved});
  EXPECT_EQ(worked.exit_code, 0) << worked.err;
  EXPECT_EQ(command({"join", moved, "-o", (scan_ / "a.ply").string()}).exit_code, 0);
}

TEST_F(Jobs, WhatIsNoJobIsRefused) {
  const std::string nowhere = (scan_ / "nowhere").string();
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"work", nowhere}, {"status", nowhere}, {"join", nowhere, "-o", "never.ply"}}) {
    const Outcome outcome = command(arguments);
    EXPECT_EQ(outcome.exit_code, 4) << arguments[0] << outcome.err;
    EXPECT_NE(outcome.err.find("is no job"), std::string::npos) << outcome.err;
  }
  ASSERT_NO_FATAL_FAILURE(plan());
  EXPECT_EQ(command({"plan", scan_.recording().string(), "-o", job()}).exit_code, 8) << "never overwritten";
  EXPECT_EQ(command({"work", job(), "--brick", "100000"}).exit_code, 2);
  std::fstream(scan_ / "job" / "plan", std::ios::in | std::ios::out | std::ios::binary)
      .seekp(200)
      .put('\x5a')
      .put('\x17');
  EXPECT_EQ(command({"work", job()}).exit_code, 4);
}

TEST_F(Jobs, WhatNeedsTheWholeVolumeIsNotPlanned) {
  const Outcome closed = command({"plan", scan_.recording().string(), "-o", job(), "--set", "finish.watertight=full"});
  EXPECT_EQ(closed.exit_code, 2);
  EXPECT_NE(closed.err.find("finish.watertight"), std::string::npos) << closed.err;
  EXPECT_FALSE(fs::exists(job())) << "all or nothing";
}

}  // namespace
}  // namespace scanknit
