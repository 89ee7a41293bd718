#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "core/system/try_in_child.h"

namespace scanknit {
namespace {

constexpr std::size_t kMebibyte = 1u << 20;
constexpr ChildLimits kLimits{.memory_bytes = 64 * kMebibyte, .seconds = 1};

TEST(TryInChild, GivesTheResultOfTheWork) {
  EXPECT_TRUE(try_in_child([] { return Result<void>(); }, kLimits));
  const auto failed = try_in_child([]() -> Result<void> { return Error{ErrorCode::kUsage, "no"}; }, kLimits);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kUsage);
  EXPECT_EQ(failed.error().message, "no");
}

TEST(TryInChild, LeavesThisProcessAsItIs) {
  int changed = 0;
  EXPECT_TRUE(try_in_child(
      [&] {
        changed = 1;
        return Result<void>();
      },
      kLimits));
  EXPECT_EQ(changed, 0);
}

TEST(TryInChild, SurvivesACrash) {
  for (const bool throws : {false, true}) {
    const auto crashed = try_in_child(
        [&]() -> Result<void> {
          if (throws) throw std::runtime_error("thrown");
          std::abort();
        },
        kLimits);
    ASSERT_FALSE(crashed);
    EXPECT_EQ(crashed.error().code, ErrorCode::kInput);
    EXPECT_EQ(crashed.error().message == "thrown", throws) << crashed.error().message;
  }
}

TEST(TryInChild, AllowsNoMoreMemoryThanItsLimit) {
  const auto takes = [](std::size_t bytes) {
    return try_in_child(
        [&] {
          const std::vector<char> memory(bytes, 1);
          return memory.back() == 1 ? Result<void>() : Error{ErrorCode::kInternal, "not written"};
        },
        kLimits);
  };
  EXPECT_TRUE(takes(16 * kMebibyte));
  const auto too_much = takes(128 * kMebibyte);
  ASSERT_FALSE(too_much);
  EXPECT_EQ(too_much.error().code, ErrorCode::kInput);
  EXPECT_NE(too_much.error().message.find("memory"), std::string::npos) << too_much.error().message;
}

TEST(TryInChild, EndsWorkThatTakesTooLong) {
  const auto endless = try_in_child(
      []() -> Result<void> {
        for (std::atomic<unsigned> turns = 0;; ++turns) {
        }
      },
      kLimits);
  ASSERT_FALSE(endless);
  EXPECT_EQ(endless.error().code, ErrorCode::kInput);
  EXPECT_NE(endless.error().message.find("too long"), std::string::npos) << endless.error().message;
}

}  // namespace
}  // namespace scanknit
