// fusion.memory_budget is that of the whole process: what the kernel counts of it, at the end, is the peak of the
// report.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::size_t kBudgetMib = 192;
constexpr double kMostOverBudget = 1.15;

/// A room whose volume and mesh take 240 MiB at voxels of 8 mm.
class MemoryBudget : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;  // gtest keeps a suite's things so
    const Outcome made = scanknit_command({"synth", "room", "--frames", "8", "--width", "640", "--height", "480",
                                           "--noise", "-o", recording(), "--quiet"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string recording() { return (*folder_ / "recording").string(); }
  static fs::path place(const std::string& name) { return *folder_ / name; }

  static Outcome run(const std::string& name, std::size_t budget_mib, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"run",   recording(),
                                          "-o",    place(name).string(),
                                          "--set", "fusion.voxel_size=8mm",
                                          "--set", "fusion.memory_budget=" + std::to_string(budget_mib) + "MiB"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  static Json report(const std::string& name) {
    return Json::parse(read_text(place(name) / "report.json"), nullptr, false);
  }
  static double peak_mib(const std::string& name) { return report(name)["peak_rss_mib"].get<double>(); }

  static TempFolder* folder_;
};

TempFolder* MemoryBudget::folder_ = nullptr;

TEST_F(MemoryBudget, IsTheWholeProcessAndTheMeshIsTheSame) {
  ASSERT_EQ(run("roomy", 4096).exit_code, 0);
  ASSERT_GT(peak_mib("roomy"), kMostOverBudget * kBudgetMib) << "nothing is tested";
  const Outcome tight = run("tight", kBudgetMib);
  ASSERT_EQ(tight.exit_code, 0) << tight.err;
  EXPECT_LE(peak_mib("tight"), kMostOverBudget * kBudgetMib) << report("tight")["stages"];
  EXPECT_EQ(read_text(place("tight") / "model.ply"), read_text(place("roomy") / "model.ply"));
}

TEST_F(MemoryBudget, WhatIsTooLargeToBeFinishedIsFinishedWithLargerVoxels) {
  for (const std::string budget : {"192", "384"}) {  // the volume is in parts; it is in memory
    const Outcome closed =
        run("closed" + budget, std::stoul(budget),
            {"--set", "finish.watertight=full", "--set", "finish.smooth=2", "--set", "finish.triangles=50000"});
    ASSERT_EQ(closed.exit_code, 0) << closed.err;
    EXPECT_NE(closed.err.find("The mesh is made of voxels of "), std::string::npos) << closed.err;
    EXPECT_LE(peak_mib("closed" + budget), kMostOverBudget * std::stod(budget)) << report("closed" + budget)["stages"];
    EXPECT_EQ(report("closed" + budget)["mesh"]["boundary_edges"], 0);
  }
}

TEST_F(MemoryBudget, OfAMeshThatIsTooLargeToBeSimplifiedToo) {
  const Outcome simplified = run("simplified", kBudgetMib, {"--set", "finish.triangles=20000"});
  ASSERT_EQ(simplified.exit_code, 0) << simplified.err;
  EXPECT_NE(simplified.err.find("The mesh is made of voxels of 16 mm"), std::string::npos) << simplified.err;
  EXPECT_LE(peak_mib("simplified"), kMostOverBudget * kBudgetMib) << report("simplified")["stages"];
}

TEST_F(MemoryBudget, ThatIsTooSmallIsRefusedBeforeTheWorkWithTheFigureThatIsEnough) {
  const Outcome refused = run("refused", kBudgetMib, {"--set", "fusion.bricks=off"});
  EXPECT_EQ(refused.exit_code, 9) << refused.err;
  EXPECT_EQ(refused.err.find("fusing"), std::string::npos) << refused.err;
  EXPECT_FALSE(fs::exists(place("refused") / "model.ply"));
  std::smatch found;
  ASSERT_TRUE(std::regex_search(
      refused.err, found,
      std::regex("needs about ([0-9]+) MiB at 8 mm voxels, more than fusion\\.memory_budget \\(192 MiB\\)")))
      << refused.err;
  const std::size_t figure_mib = std::stoul(found[1]);
  const Outcome taken = run("taken", figure_mib, {"--set", "fusion.bricks=off"});
  EXPECT_EQ(taken.exit_code, 0) << taken.err;
  EXPECT_LE(peak_mib("taken"), kMostOverBudget * static_cast<double>(figure_mib));
}

}  // namespace
}  // namespace scanknit
