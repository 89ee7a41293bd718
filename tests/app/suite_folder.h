// A folder that the tests of a suite share.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/app/program.h"

namespace scanknit {

/// A suite's recording and all that its tests write, removed after its last test. A suite that has more to set up calls
/// this SetUpTestSuite() first.
class SuiteFolder : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { folder_ = std::make_unique<TempFolder>(); }
  static void TearDownTestSuite() { folder_.reset(); }

  [[nodiscard]] static std::string place(const std::string& name) { return *folder_ / name; }
  [[nodiscard]] static std::string recording() { return place("recording"); }
  /// report.json of an output folder, which is named by its place(), too.
  [[nodiscard]] static nlohmann::json report(const std::string& output) {
    return nlohmann::json::parse(read_text(std::filesystem::path(place(output)) / "report.json"));
  }

 private:
  inline static std::unique_ptr<TempFolder> folder_;  ///< suites run one after the other
};

}  // namespace scanknit
