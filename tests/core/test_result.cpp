#include <gtest/gtest.h>

#include <memory>

#include "core/result.h"

namespace scanknit {
namespace {

Result<int> half(int number) {
  if (number % 2 != 0) return Error{ErrorCode::kInput, "is odd", "number"};
  return number / 2;
}

TEST(Result, HoldsAValueOrAnError) {
  EXPECT_EQ(*half(8), 4);
  EXPECT_FALSE(half(7).has_value());
  EXPECT_EQ(half(7).error().text(), "number: is odd");
}

TEST(Result, AndThenGoesOnWithTheValue) {
  EXPECT_EQ(*half(8).and_then(half), 2);
}

TEST(Result, AndThenHandsTheErrorOn) {
  EXPECT_EQ(half(7).and_then(half).error().message, "is odd");
  EXPECT_EQ(half(6).and_then(half).error().message, "is odd");
}

TEST(Result, MovesWhatCannotBeCopied) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(3));
  const std::unique_ptr<int> taken = *std::move(result);
  EXPECT_EQ(*taken, 3);
}

TEST(Result, OfNothingIsFineUntilAnError) {
  EXPECT_TRUE(Result<void>{});
  const Result<void> failed = Error{ErrorCode::kOutput, "full"};
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().text(), "full");
}

TEST(ResultDeathTest, AskingForTheMissingValueIsAFaultOfOurs) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(static_cast<void>(half(7).value()), "broken promise");
  EXPECT_DEATH(static_cast<void>(half(8).error()), "broken promise");
}

}  // namespace
}  // namespace scanknit
