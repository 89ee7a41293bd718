#include <gtest/gtest.h>

#include "app/live/view_budget.h"

namespace scanknit {
namespace {

using namespace std::chrono_literals;
using Clock = ViewBudget::Clock;

TEST(ViewBudget, EarnsATwentyFifthOfTheTimeBetweenFrames) {
  ViewBudget budget;
  Clock::time_point now{};
  budget.go_on(now);
  budget.earn(now += 100ms);
  EXPECT_TRUE(budget.allows(4ms));
  EXPECT_FALSE(budget.allows(5ms));
  budget.spend(4ms);
  EXPECT_FALSE(budget.allows(1ms));
  EXPECT_DOUBLE_EQ(budget.share(), 0.04);
}

TEST(ViewBudget, APauseEarnsNothing) {
  ViewBudget budget;
  Clock::time_point now{};
  budget.go_on(now);
  budget.go_on(now += 1h);
  budget.earn(now += 20ms);
  EXPECT_FALSE(budget.allows(2ms));
}

TEST(ViewBudget, ASilentScannerSavesUpNoBurst) {
  ViewBudget budget;
  Clock::time_point now{};
  budget.go_on(now);
  for (int frame = 0; frame < 5; ++frame) budget.earn(now += 1min);
  budget.spend(50ms);
  EXPECT_FALSE(budget.allows(1ms));
}

TEST(ViewBudget, WorkThatIsTooLongForAnySavingIsDoneAndPaidBack) {
  ViewBudget budget;
  Clock::time_point now{};
  budget.go_on(now);
  for (int frame = 0; frame < 100; ++frame) budget.earn(now += 20ms);
  EXPECT_TRUE(budget.allows(1s));
  budget.spend(1s);
  int waited = 0;
  for (; !budget.allows(1ms); ++waited) budget.earn(now += 20ms);
  EXPECT_NEAR(waited, 1189, 2);
}

}  // namespace
}  // namespace scanknit
