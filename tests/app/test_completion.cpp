// Completion in the shells themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/app/command_help.h"
#include "tests/app/program.h"
#include "tests/support/text.h"

namespace scanknit {
namespace {

using Words = std::vector<std::string>;

bool has(const Words& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

using test::contains;

Words lines_of(const std::string& text) {
  std::istringstream stream(text);
  Words lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

bool is_installed(const std::string& shell) {
  return std::system(("command -v " + shell + " >/dev/null 2>&1").c_str()) == 0;
}

/// A shell in a folder with a file and a folder, and the script of that shell.
class CompletionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder_ / "scans");
    std::ofstream(folder_ / "desk.mcap") << "x";
  }

  void write_script(const std::string& shell) {
    const Outcome outcome = scanknit_command({"completion", shell});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    std::ofstream(folder_ / "completion") << outcome.out;
  }

  /// What `shell` prints. `code` is a program for it.
  Outcome run_shell(const std::string& shell, const std::string& code) {
    std::ofstream(folder_ / "code") << code;
    const std::string where = folder_.path().string();
    const int status =
        std::system(("cd '" + where + "' && " + shell + " ./code > out.txt 2> err.txt < /dev/null").c_str());
    return {status, read_text(folder_ / "out.txt"), read_text(folder_ / "err.txt")};
  }

  /// What bash offers after these words, the last of which is being typed.
  Words bash_offers(const Words& words) {
    std::string code = "source ./completion\nCOMP_WORDS=(";
    for (const std::string& word : words) code += "'" + word + "' ";
    code += ")\nCOMP_CWORD=" + std::to_string(words.size() - 1) +
            "\nset -u\n_scanknit || exit 1\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
    const Outcome outcome = run_shell("bash --norc --noprofile", code);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    Words offers = lines_of(outcome.out);
    std::erase(offers, "");
    return offers;
  }

  TempFolder folder_;
};

TEST_F(CompletionTest, EveryCommandAndEveryOptionOfHelpIsOffered) {
  write_script("bash");
  const std::string zsh = scanknit_command({"completion", "zsh"}).out;
  const std::string fish = scanknit_command({"completion", "fish"}).out;
  const Words paths = all_paths();
  ASSERT_GT(paths.size(), 15u);
  for (const std::string& path : paths) {
    Words words = arguments_of(path);
    words.insert(words.begin(), "scanknit");
    Words options = words;
    options.emplace_back("-");
    Words offered = bash_offers(options), expected = options_of(path);
    std::sort(offered.begin(), offered.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(offered, expected) << path;
    EXPECT_GE(expected.size(), 2u) << path;
    for (const std::string& option : expected) {
      EXPECT_TRUE(contains(zsh, option)) << path << ' ' << option;
      EXPECT_TRUE(contains(fish, option.substr(option.find_first_not_of('-')))) << path << ' ' << option;
    }

    const Words commands = commands_of(path);
    if (commands.empty()) continue;
    words.emplace_back("");
    EXPECT_EQ(bash_offers(words), commands) << path;
    for (const std::string& command : commands) {
      EXPECT_TRUE(contains(zsh, "'" + command + ":")) << command;
      EXPECT_TRUE(contains(fish, " -a " + command + " -d ")) << command;
    }
  }
}

TEST_F(CompletionTest, BashOffersTheWordsOfAnOption) {
  write_script("bash");
  EXPECT_EQ(bash_offers({"scanknit", "run", "--pace", ""}), (Words{"fast", "realtime", "stepped"}));
  EXPECT_EQ(bash_offers({"scanknit", "run", "--pace", "r"}), Words{"realtime"});
  EXPECT_EQ(bash_offers({"scanknit", "run", "--pace", "=", "s"}), Words{"stepped"});
  EXPECT_EQ(bash_offers({"scanknit", "run", "--pace", "="}), (Words{"fast", "realtime", "stepped"}));
  EXPECT_EQ(bash_offers({"scanknit", "run", "--preset", "turn"}), Words{"turntable"});
  EXPECT_EQ(bash_offers({"scanknit", "convert", "--to", "open"}), Words{"open3d"});
  EXPECT_EQ(bash_offers({"scanknit", "info", "--type", "dou"}), Words{"double"});
  EXPECT_TRUE(has(bash_offers({"scanknit", "extract", "--decider", ""}), "trilinear"));
  EXPECT_EQ(bash_offers({"scanknit", "run", "--set", "fusion.voxel"}), Words{"fusion.voxel_size="});
  EXPECT_EQ(bash_offers({"scanknit", "run", "--set", "fusion.voxel_size", "="}), Words{});
  EXPECT_EQ(bash_offers({"scanknit", "run", "--set", "fusion.voxel_size", "=", "d"}), Words{});
  EXPECT_EQ(bash_offers({"scanknit", "completion", ""}), (Words{"bash", "zsh", "fish"}));
  EXPECT_EQ(bash_offers({"scanknit", "run", "--threads", ""}), Words{}) << "a number is no file";
}

TEST_F(CompletionTest, BashOffersFilesAndFoldersWhereTheyBelong) {
  write_script("bash");
  EXPECT_EQ(bash_offers({"scanknit", "run", "de"}), Words{"desk.mcap"});
  EXPECT_EQ(bash_offers({"scanknit", "run", "desk.mcap", "-o", "sc"}), Words{"scans"});
  EXPECT_EQ(bash_offers({"scanknit", "run", "--config", "de"}), Words{"desk.mcap"});
  EXPECT_EQ(bash_offers({"scanknit", "synth", "-o", ""}), Words{"scans"}) << "folders only";
  EXPECT_EQ(bash_offers({"scanknit", "synth", "turn"}), Words{"turntable"});
  EXPECT_EQ(bash_offers({"scanknit", "synth", "des"}), (Words{"desk", "desk.mcap"})) << "a scene, or a mesh";
}

TEST_F(CompletionTest, FishOffersCommandsOptionsAndWords) {
  if (!is_installed("fish")) GTEST_SKIP() << "fish is not installed";
  write_script("fish");
  const auto offers = [&](const std::string& line) {
    const Outcome outcome = run_shell("fish --no-config", "source ./completion\ncomplete -C '" + line + "'\n");
    EXPECT_EQ(outcome.err, "");
    Words words = lines_of(outcome.out);
    for (std::string& word : words) word = word.substr(0, word.find('\t'));
    return words;
  };
  for (const std::string& command : commands_of("")) EXPECT_TRUE(has(offers("scanknit "), command)) << command;
  for (const std::string& option : options_of("run")) {
    const bool is_long = option.size() > 2;
    EXPECT_TRUE(!is_long || has(offers("scanknit run " + option), option)) << option;
  }
  EXPECT_EQ(offers("scanknit run --pace r"), Words{"realtime"});
  EXPECT_TRUE(has(offers("scanknit run de"), "desk.mcap"));
  EXPECT_TRUE(has(offers("scanknit config pr"), "print"));
}

TEST_F(CompletionTest, ZshTakesTheScriptAndBindsItToTheProgram) {
  if (!is_installed("zsh")) GTEST_SKIP() << "zsh is not installed";
  write_script("zsh");
  const Outcome outcome = run_shell("zsh -f",
                                    "autoload -Uz compinit && compinit -u -d ./dump\nsource ./completion\n"
                                    "print -r -- $_comps[scanknit] $+functions[_scanknit_run]\n");
  EXPECT_EQ(outcome.out, "_scanknit 1\n") << outcome.err;
  EXPECT_EQ(outcome.err, "");
}

TEST(Completion, AnUnknownShellIsAUsageError) {
  const Outcome outcome = scanknit_command({"completion", "tcsh"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("bash, zsh, fish"), std::string::npos) << outcome.err;
  EXPECT_EQ(scanknit_command({"completion"}).exit_code, 2);
}

}  // namespace
}  // namespace scanknit
