// The manual pages, as `man` shows them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <tuple>

#include "app/exit_codes.h"
#include "core/version.h"
#include "tests/app/command_help.h"
#include "tests/app/program.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

std::string page_name(const std::string& path) {
  std::string name = path.empty() ? "scanknit" : "scanknit " + path;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name + ".1";
}

/// The page's source with troff's escapes of '-' undone.
std::string plain(std::string text) {
  for (std::size_t at = text.find("\\-"); at != std::string::npos; at = text.find("\\-", at)) text.erase(at, 1);
  return text;
}

class ManPages : public ::testing::Test {
 protected:
  void SetUp() override {
    const Outcome outcome = scanknit_command({"man", "-o", (folder_ / "man").string()});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }

  std::string page(const std::string& name) { return read_text(folder_ / "man" / name); }

  /// The names of the pages that were written.
  std::vector<std::string> pages() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "man")) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  /// What the shell command prints, errors included, with the page as $PAGE.
  std::string output_of(const std::string& command, const std::string& name) {
    const std::string file = (folder_ / "man" / name).string();
    const std::string out = (folder_ / "printed").string();
    std::ignore = std::system(("PAGE='" + file + "'; (" + command + ") > '" + out + "' 2>&1 < /dev/null").c_str());
    return read_text(out);
  }

  TempFolder folder_;
};

TEST_F(ManPages, ThereIsOneForEachCommandAndItNamesWhatHelpNames) {
  std::vector<std::string> expected;
  for (const std::string& path : all_paths()) {
    expected.push_back(page_name(path));
    const std::string text = plain(page(page_name(path)));
    for (const std::string& command : commands_of(path)) {
      EXPECT_NE(text.find("\\fB" + command + "\\fR"), std::string::npos) << path << ": " << command;
    }
    for (const std::string& option : options_of(path)) {
      EXPECT_NE(text.find("\\fB" + option + "\\fR"), std::string::npos) << path << ": " << option;
    }
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(pages(), expected);
}

TEST_F(ManPages, NameTheExitCodesEnvironmentAndFiles) {
  const std::string text = page("scanknit.1");
  for (const ExitCode& exit : kExitCodes) {
    EXPECT_NE(text.find(".B " + std::to_string(exit.code) + "\n" + std::string(exit.text)), std::string::npos)
        << exit.code;
  }
  EXPECT_NE(text.find("NO_COLOR"), std::string::npos);
  EXPECT_NE(text.find("60\\-scanknit.rules"), std::string::npos);
}

/// The same for the same sources, whenever they are built: the changelog's.
TEST_F(ManPages, HaveTheDateOfTheRelease) {
  const std::string changes = read_text(test::kSourceDir + "/CHANGELOG.md");
  const std::string head = std::string("\n## [") + kVersion + "] - ";
  const std::size_t at = changes.find(head);
  const std::string date = at == std::string::npos ? "unreleased" : changes.substr(at + head.size(), 10);
  for (const std::string& name : pages()) {
    std::string first_line = page(name).substr(0, page(name).find('\n'));
    std::erase(first_line, '\\');
    EXPECT_NE(first_line.find(" 1 \"" + date + "\" \"scanknit"), std::string::npos) << first_line;
  }
}

TEST_F(ManPages, ManHasNoWarning) {
  if (std::system("command -v man groff >/dev/null 2>&1") != 0) GTEST_SKIP() << "man and groff are not installed";
  for (const std::string& name : pages()) {
    EXPECT_EQ(
        output_of("LC_ALL=C.UTF-8 MANWIDTH=100 man --warnings=all -E UTF-8 -l -Tutf8 -Z \"$PAGE\" >/dev/null", name),
        "")
        << name;
  }
}

TEST_F(ManPages, ManShowsTheOptionsToReaders) {
  if (std::system("command -v man groff >/dev/null 2>&1") != 0) GTEST_SKIP() << "man and groff are not installed";
  const std::string shown =
      output_of("LC_ALL=C.UTF-8 MANWIDTH=100 man -E UTF-8 -l \"$PAGE\" | col -b", "scanknit-run.1");
  EXPECT_NE(shown.find("--save-volume FILE.vdb"), std::string::npos) << shown;
  EXPECT_NE(shown.find("-o, --output OUT"), std::string::npos) << shown;
}

TEST_F(ManPages, MandocFindsNoError) {
  if (std::system("command -v mandoc >/dev/null 2>&1") != 0) GTEST_SKIP() << "mandoc is not installed";
  for (const std::string& name : pages()) {
    EXPECT_EQ(output_of("mandoc -T lint -W error \"$PAGE\"", name), "") << name;
  }
}

TEST(ManCommand, AFolderThatCannotBeWrittenExitsWith8) {
  EXPECT_EQ(scanknit_command({"man", "-o", "/proc/nowhere"}).exit_code, 8);
}

}  // namespace
}  // namespace scanknit
