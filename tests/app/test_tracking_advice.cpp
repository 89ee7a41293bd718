// Whoever is told why tracking is weak or lost is told what to do.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>

#include "app/live/tracking_advice.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

TEST(TrackingAdvice, ThereIsOneForEveryReasonAndTheReportsPageNamesThem) {
  std::ifstream docs(std::filesystem::path(test::kSourceDir) / "docs/report.md");
  const std::regex row(R"(^\| `([a-z ]+)` \| (weak|lost) \|.*)");
  std::set<std::string> described;
  for (std::string line; std::getline(docs, line);) {
    std::smatch match;
    if (std::regex_match(line, match, row)) described.insert(match[1]);
  }
  std::set<std::string> known;
  for (auto reason = TrackReason::kNothingSeen; reason <= TrackReason::kRecordedPoseKept;
       reason = static_cast<TrackReason>(static_cast<int>(reason) + 1)) {
    EXPECT_FALSE(tracking_advice(reason).empty()) << to_string(reason);
    known.insert(to_string(reason));
  }
  EXPECT_EQ(known, described);
}

TEST(TrackingAdvice, WhatIsNoReasonHasNone) {
  EXPECT_EQ(tracking_advice(TrackReason::kNone), "");
}

}  // namespace
}  // namespace scanknit
