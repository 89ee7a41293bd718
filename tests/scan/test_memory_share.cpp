// The budget is the process's: the volume gets a part of it, and the steps after it what is left.
#include <gtest/gtest.h>

#include "scan/checks/memory_share.h"
#include "scan/mesh/memory_left.h"

namespace scanknit {
namespace {

TEST(MemoryShare, OfTheVolumeLeavesRoomForTheProgramAndAMesh) {
  constexpr double kMeshShare = 0.4;  // of the volume's size
  for (const std::size_t budget_mib : {std::size_t{256}, std::size_t{512}, std::size_t{1024}, std::size_t{4096}}) {
    const auto volume_mib = static_cast<double>(volume_budget_mib(budget_mib));
    EXPECT_LE(static_cast<double>(kProgramMib) + (1 + kMeshShare) * volume_mib, static_cast<double>(budget_mib));
    EXPECT_GE(volume_mib, 0.25 * static_cast<double>(budget_mib));
  }
}

TEST(MemoryShare, OfTheVolumeIsNeverTooLittleForAnyScan) {
  EXPECT_EQ(volume_budget_mib(kLeastMemoryBudgetMib), kLeastMemoryBudgetMib);
  EXPECT_EQ(volume_budget_mib(kLeastMemoryBudgetMib - 1), kLeastMemoryBudgetMib - 1) << "is refused as it was given";
  EXPECT_EQ(volume_budget_mib(64), 16u);
}

TEST(MemoryLeft, IsTheBudgetWithoutTheProgramAndWhatWasTaken) {
  constexpr std::size_t kMebibyte = 1 << 20;
  EXPECT_EQ(memory_left_bytes(kProgramMib + 100, 30 * kMebibyte), 70 * kMebibyte);
  EXPECT_EQ(memory_left_bytes(kProgramMib + 100, 101 * kMebibyte), 0u);
  EXPECT_EQ(memory_left_bytes(kProgramMib - 1, 0), 0u);
}

}  // namespace
}  // namespace scanknit
