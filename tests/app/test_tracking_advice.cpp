// Whoever is told why tracking is weak or lost is told what to do.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include "app/live/tracking_advice.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

TEST(TrackingAdvice, ThereIsOneForEveryReasonOfTheReport) {
  std::ifstream docs(std::filesystem::path(test::kSourceDir) / "docs/report.md");
  const std::regex row(R"(^\| `([a-z ]+)` \| (weak|lost) \|.*)");
  int reasons = 0;
  for (std::string line; std::getline(docs, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    ++reasons;
    EXPECT_FALSE(tracking_advice(match[1].str()).empty()) << match[1];
  }
  EXPECT_GE(reasons, 12);
}

TEST(TrackingAdvice, WhatIsNoReasonHasNone) {
  EXPECT_EQ(tracking_advice(""), "");
}

}  // namespace
}  // namespace scanknit
