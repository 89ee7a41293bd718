// BrickClaim: one worker at a brick, whatever the clocks of the machines say.
#include "scan/job/brick_claim.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/core/temporary_folder.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

class BrickClaims : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path claim() const { return folder_ / "7.claim"; }
  /// As if a machine whose clock is off had set the file's time.
  void set_age(std::chrono::seconds age) const { fs::last_write_time(claim(), fs::file_time_type::clock::now() - age); }

  TemporaryFolder folder_;
};

TEST_F(BrickClaims, OneWorkerHasTheBrickUntilItEnds) {
  {
    const auto first = BrickClaim::take(claim());
    ASSERT_TRUE(first && *first);
    const auto second = BrickClaim::take(claim());
    ASSERT_TRUE(second);
    EXPECT_EQ(*second, nullptr);
    EXPECT_TRUE(*BrickClaim::is_taken(claim()));
  }
  EXPECT_FALSE(fs::exists(claim()));
  EXPECT_FALSE(*BrickClaim::is_taken(claim()));
}

TEST_F(BrickClaims, AClaimAnHourOffTheFileSystemsClockIsADeadWorkers) {
  for (const std::chrono::hours age : {std::chrono::hours(1), std::chrono::hours(-1)}) {
    std::ofstream(claim()) << "another machine\n";
    set_age(age);
    EXPECT_FALSE(*BrickClaim::is_taken(claim())) << age.count();
    const auto taken = BrickClaim::take(claim());
    ASSERT_TRUE(taken && *taken) << age.count();
    EXPECT_TRUE(*BrickClaim::is_taken(claim()));
  }
}

TEST_F(BrickClaims, AWorkerWhoseClaimWasTakenOverLeavesItToTheOther) {
  auto slow = BrickClaim::take(claim());
  ASSERT_TRUE(slow && *slow);
  set_age(std::chrono::hours(1));
  const auto other = BrickClaim::take(claim());
  ASSERT_TRUE(other && *other);
  slow->reset();
  EXPECT_TRUE(fs::exists(claim()));
  EXPECT_TRUE(*BrickClaim::is_taken(claim()));
}

}  // namespace
}  // namespace scanknit::test
