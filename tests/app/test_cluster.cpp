// A scan on a cluster gives the files of one process, whatever happens to nodes. With a real Slurm, where it is
// installed.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "tests/app/slurm_cluster.h"
#include "tests/app/suite_folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

const Words kSettings = {"--set", "fusion.voxel_size=4mm", "--set", "fusion.bricks=64"};

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

template <typename Condition>
bool comes_true(const Condition& condition) {
  for (int tries = 0; tries < 600; ++tries) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}

class Cluster : public SuiteFolder {
 protected:
  static void SetUpTestSuite() {
    SuiteFolder::SetUpTestSuite();
    if (!SlurmCluster::is_installed()) return;
    slurm_ = std::make_unique<SlurmCluster>();
    const Words synth = {"synth", "tower", "--frames", "48", "--width", "320", "--height", "240", "-o", recording()};
    ASSERT_EQ(scanknit_command(synth).exit_code, 0);
    ASSERT_EQ(scanknit_command(joined({"run", recording(), "-o", place("run")}, kSettings)).exit_code, 0);
  }
  static void TearDownTestSuite() {
    slurm_.reset();
    SuiteFolder::TearDownTestSuite();
  }
  void SetUp() override {
    if (!slurm_)
      GTEST_SKIP() << "SKIPPED: the Debian packages slurmctld, slurmd, slurm-client and munge are not installed";
    ASSERT_TRUE(slurm_->is_ready());
  }

  /// `cluster JOB -o OUT`, for the name of a test.
  static Words cluster(const std::string& name, const Words& more = {}) {
    return joined({"cluster", place(name + ".job"), "-o", place(name), "--slurm", "--array-size", "4"}, more);
  }
  static Words planned() { return joined({"--", recording()}, kSettings); }
  static void expect_files_of_run(const std::string& name) {
    std::size_t compared = 0;
    for (const auto& entry : fs::directory_iterator(place("run"))) {
      const std::string file = entry.path().filename();
      if (file.starts_with("report.")) continue;  // has times
      EXPECT_EQ(read_text(fs::path(place(name)) / file), read_text(entry.path())) << file << " bit by bit";
      ++compared;
    }
    EXPECT_GE(compared, 3u);
  }

  inline static std::unique_ptr<SlurmCluster> slurm_;
};

TEST_F(Cluster, PlansFusesAndJoins) {
  const Outcome outcome = scanknit_command(cluster("all", planned()));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("Written"), std::string::npos) << "what join prints: " << outcome.out;
  EXPECT_NE(outcome.err.find("fusing bricks"), std::string::npos) << outcome.err;
  EXPECT_EQ(slurm_->queued(), 0);
  expect_files_of_run("all");
}

TEST_F(Cluster, FusesAgainWhatALostNodeLeft) {
  Program follower(cluster("lost", planned()));
  const fs::path claims = fs::path(place("lost.job")) / "claims";
  const auto is_at_work = [&] {
    std::error_code code;
    return fs::exists(claims, code) && !fs::is_empty(claims, code) && slurm_->program_on(1) != 0;
  };
  ASSERT_TRUE(comes_true(is_at_work)) << follower.err_so_far();
  slurm_->lose_node(1);
  for (const auto& claim : fs::directory_iterator(claims)) {  // the lease of a minute is over
    std::error_code code;
    fs::last_write_time(claim.path(), fs::file_time_type::clock::now() - std::chrono::hours(1), code);
  }
  const Outcome outcome = follower.wait();
  slurm_->return_node(1);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  expect_files_of_run("lost");
}

TEST_F(Cluster, GoesOnWithoutTheProcessThatSubmitted) {
  Program follower(cluster("alone", planned()));
  ASSERT_TRUE(comes_true([&] { return slurm_->queued() > 0; }));
  follower.send(SIGKILL);
  EXPECT_EQ(follower.wait().exit_code, 128 + SIGKILL);
  const Outcome second = scanknit_command(cluster("alone", planned()));
  ASSERT_EQ(second.exit_code, 0) << second.err;
  expect_files_of_run("alone");
}

TEST_F(Cluster, IsSubmittedOnceByTwoProcesses) {
  Program one(cluster("twice", planned())), two(cluster("twice", planned()));
  const Outcome first = one.wait(), second = two.wait();
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(second.exit_code, 0) << second.err;
  const auto submits = [](const Outcome& outcome) { return outcome.err.find("submitted") != std::string::npos; };
  EXPECT_NE(submits(first), submits(second)) << first.err << second.err;
  expect_files_of_run("twice");
}

TEST_F(Cluster, LeavesOnCtrlC) {
  Program follower(cluster("left", joined({"--sbatch=--hold"}, planned())));
  ASSERT_TRUE(comes_true([&] { return slurm_->queued() == 6; })) << "plan, four workers, join";
  follower.send(SIGINT);
  const Outcome outcome = follower.wait();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_NE(outcome.err.find("--cancel"), std::string::npos) << outcome.err;
  EXPECT_EQ(slurm_->queued(), 6);
  EXPECT_EQ(scanknit_command({"cluster", place("left.job"), "--slurm", "--cancel"}).exit_code, 0);
  EXPECT_EQ(scanknit_command({"cluster", place("never.job"), "--slurm", "--cancel"}).exit_code, 4);
  EXPECT_TRUE(comes_true([&] { return slurm_->queued() == 0; }));
}

TEST_F(Cluster, IsCancelled) {
  Program follower(cluster("cancelled", joined({"--sbatch=--hold"}, planned())));
  ASSERT_TRUE(comes_true([&] { return follower.err_so_far().find("waiting for Slurm") != std::string::npos; }));
  const Outcome cancelled = scanknit_command({"cluster", place("cancelled.job"), "--slurm", "--cancel", "--json"});
  EXPECT_EQ(nlohmann::json::parse(cancelled.out)["cancelled"], 3) << "plan, workers, join";
  const Outcome outcome = follower.wait();
  EXPECT_EQ(outcome.exit_code, 130) << outcome.err;
  EXPECT_EQ(slurm_->queued(), 0) << "nothing is submitted again";
}

TEST_F(Cluster, SaysWhyPlanningFailed) {
  const Outcome outcome = scanknit_command(cluster("nothing", {"--", place("no recording")}));
  EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
  EXPECT_NE(outcome.err.find("no such file or folder"), std::string::npos) << outcome.err;
  EXPECT_EQ(slurm_->queued(), 0);
}

TEST_F(Cluster, SaysWhyWorkersFailed) {
  const fs::path changed = place("changed");
  fs::copy(recording(), changed, fs::copy_options::recursive);
  ASSERT_EQ(scanknit_command(joined({"plan", changed, "-o", place("frames.job")}, kSettings)).exit_code, 0);
  fs::copy_file(changed / "depth" / "000001.png", changed / "depth" / "000000.png",
                fs::copy_options::overwrite_existing);
  const Outcome outcome = scanknit_command(cluster("frames"));
  EXPECT_EQ(outcome.exit_code, 4) << outcome.err;
  EXPECT_NE(outcome.err.find("fusing failed with exit code 4"), std::string::npos) << outcome.err;
  EXPECT_EQ(slurm_->queued(), 0);
}

TEST_F(Cluster, RefusesAJobWhoseConfigurationWasChanged) {
  const std::string job = place("settings.job");
  ASSERT_EQ(scanknit_command(joined({"plan", recording(), "-o", job}, kSettings)).exit_code, 0);
  std::ofstream(fs::path(job) / "config.yaml", std::ios::app) << "# changed\n";
  const Outcome outcome = scanknit_command(cluster("settings"));
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  EXPECT_EQ(slurm_->queued(), 0);
}

TEST_F(Cluster, PassesOnWhatSlurmRefuses) {
  const Outcome outcome = scanknit_command(cluster("refused", joined({"--partition", "nowhere"}, planned())));
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_NE(outcome.err.find("partition"), std::string::npos) << outcome.err;
  EXPECT_EQ(slurm_->queued(), 0);
}

TEST_F(Cluster, DoesNotTakeAnotherPlanForThisOne) {
  const std::string job = place("other.job");
  ASSERT_EQ(scanknit_command(joined({"plan", recording(), "-o", job}, kSettings)).exit_code, 0);
  const Outcome outcome = scanknit_command(cluster("other", {"--", recording(), "--set", "fusion.voxel_size=8mm"}));
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_NE(outcome.err.find("other arguments"), std::string::npos) << outcome.err;
}

TEST(ClusterWithoutSlurm, IsRefused) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  const TempFolder folder;
  const Outcome outcome =
      scanknit_command({"cluster", folder / "job", "-o", folder / "out", "--slurm", "--", folder / "recording"});
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_NE(outcome.err.find("slurm-client"), std::string::npos) << outcome.err;
}

TEST(ClusterWithoutSlurm, NeedsItsArguments) {
  const TempFolder folder;
  const Outcome named = scanknit_command({"cluster", folder / "job", "-o", folder / "out", "--slurm",
                                          "--sbatch=--job-name=mine", "--", folder / "recording"});
  EXPECT_EQ(named.exit_code, 2);
  EXPECT_NE(named.err.find("--job-name=mine"), std::string::npos) << named.err;
  EXPECT_EQ(scanknit_command({"cluster", folder / "job", "-o", folder / "out"}).exit_code, 2) << "no engine";
  EXPECT_EQ(scanknit_command({"cluster", folder / "job", "--slurm"}).exit_code, 2) << "no output";
  EXPECT_EQ(scanknit_command({"cluster", folder / "job", "-o", folder / "out", "--slurm"}).exit_code, 4) << "no plan";
  const Outcome configured =
      scanknit_command({"cluster", folder / "job", "-o", folder / "out", "--slurm", "--set", "fusion.voxel_size=1cm"});
  EXPECT_EQ(configured.exit_code, 2);
  EXPECT_NE(configured.err.find("after --"), std::string::npos) << configured.err;
}

}  // namespace
}  // namespace scanknit
