#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/system/try_in_child.h"
#include "tests/core/temporary_folder.h"

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

/// Sleeps without an end in the first `sleepers` children.
Result<void> try_sleeping(const std::filesystem::path& folder, int sleepers) {
  constexpr ChildLimits kImpatient{.memory_bytes = 64 * kMebibyte, .seconds = 1, .stall_seconds = 0.2};
  return try_in_child(
      [&]() -> Result<void> {
        int before = 0;
        while (std::filesystem::exists(folder / std::to_string(before))) ++before;
        test::write_text(folder / std::to_string(before), "");
        if (before < sleepers) {
          for (;;) ::pause();
        }
        return {};
      },
      kImpatient);
}

TEST(TryInChild, TriesAgainWhenAChildStalls) {
  const test::TemporaryFolder folder;
  EXPECT_TRUE(try_sleeping(folder.path(), 2));
  EXPECT_EQ(folder.entries(), 3u);
}

TEST(TryInChild, GivesUpWhenAllChildrenStall) {
  const test::TemporaryFolder folder;
  const auto stalled = try_sleeping(folder.path(), 100);
  ASSERT_FALSE(stalled);
  EXPECT_EQ(stalled.error().code, ErrorCode::kBudget);
  EXPECT_EQ(folder.entries(), 3u);
}

}  // namespace
}  // namespace scanknit
