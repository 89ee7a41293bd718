// What the program loads before it does what it is asked for: few libraries, so that it starts at once.
#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/program.h"
#include "tests/app/scan.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostAtStart = 20;
constexpr std::size_t kMostOfARun = 60 - 3;  // three to spare, for the libraries of other versions of Debian

/// The file names of all libraries that the program loads: the loader (ld.so(8)) notes each as "file=NAME [0];
/// generating link map". Fails unless the program ends with exit code 0.
std::set<std::string> libraries_of(const std::vector<std::string>& arguments) {
  const TempFolder folder;
  ::setenv("LD_DEBUG", "files", 1);
  ::setenv("LD_DEBUG_OUTPUT", (folder / "loaded").c_str(), 1);
  const Outcome outcome = scanknit_command(arguments);
  ::unsetenv("LD_DEBUG");
  ::unsetenv("LD_DEBUG_OUTPUT");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;

  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    std::istringstream lines(read_text(entry.path()));
    for (std::string line; std::getline(lines, line);) {
      const std::size_t begin = line.find("file=");
      const std::size_t end = line.find(" [");
      if (begin == std::string::npos || line.find("generating link map") == std::string::npos) continue;
      names.insert(fs::path(line.substr(begin + 5, end - begin - 5)).filename().string());
    }
  }
  return names;
}

bool has(const std::set<std::string>& libraries, const std::string& beginning) {
  return std::any_of(libraries.begin(), libraries.end(),
                     [&](const std::string& name) { return name.starts_with(beginning); });
}

std::string listed(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += name + ' ';
  return text;
}

TEST(Start, WhatNeedsNoRoomLoadsNone) {
  const TempFolder folder;
  const std::string config = std::string(test::kSourceDir) + "/configs/default.yaml";
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--version"},
                                                    {"--help"},
                                                    {"run", "--help"},
                                                    {"completion", "bash"},
                                                    {"config", "print"},
                                                    {"config", "check", config},
                                                    {"config", "schema"},
                                                    {"config", "docs"},
                                                    {"man", "-o", (folder / "man").string()}}) {
    SCOPED_TRACE(arguments.front() + ' ' + arguments.back());
    const std::set<std::string> libraries = libraries_of(arguments);
    EXPECT_TRUE(has(libraries, "libc.so")) << "the loader's notes were not read: " << listed(libraries);
    EXPECT_LE(libraries.size(), kMostAtStart) << listed(libraries);
    for (const char* heavy : {"libtbb", "libopenvdb", "libopencv", "libpcl", "libscanknit_commands", "libscanknit_scan",
                              "libscanknit_acquire", "libscanknit_fusion", "libscanknit_export"}) {
      EXPECT_FALSE(has(libraries, heavy)) << heavy;
    }
  }
}

TEST(Start, InfoOfARecordingLoadsNoRoomOfAScan) {
  const Scan scan;
  const std::set<std::string> libraries = libraries_of({"info", scan.recording().string()});
  EXPECT_TRUE(has(libraries, "libscanknit_recording_commands.so"));
  for (const char* heavy : {"libopenvdb", "libscanknit_commands", "libscanknit_scan", "libscanknit_fusion"}) {
    EXPECT_FALSE(has(libraries, heavy)) << heavy;
  }
}

TEST(Start, ARunOfPicturesAndInfoLoadFewLibraries) {
  const Scan scan;
  const std::string recording = scan.recording().string();
  const std::string output = scan.output().string();
  using Arguments = std::vector<std::string>;
  for (const Arguments& arguments :
       {Arguments{"run", recording, "--set", "fusion.voxel_size=8mm", "-o", output},
        {"run", recording, "--preset", "print", "--set", "fusion.voxel_size=8mm", "-o", output + "_print"},
        {"run", recording, "--poses", "track", "--set", "fusion.voxel_size=8mm", "-o", output + "_track"},
        {"info", output + "/model.glb"}}) {
    SCOPED_TRACE(arguments.front() + ' ' + arguments.back());
    const std::set<std::string> libraries = libraries_of(arguments);
    EXPECT_TRUE(has(libraries, "libscanknit_commands.so"));
    EXPECT_LE(libraries.size(), kMostOfARun) << listed(libraries);
    for (const char* heavy :
         {"libpcl_io", "libpcl_features", "libpcl_filters", "libvtk", "libITK", "libgdcm", "libopencv_aruco",
          "libscanknit_synth", "libscanknit_calibrate", "libscanknit_measure", "libgdal", "libcurl", "libOpenNI2"}) {
      EXPECT_FALSE(has(libraries, heavy)) << heavy;
    }
  }
}

/// The program in a folder where its modules are not.
class WithoutItsModule : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::copy(test::kProgram, folder_.path());
    for (const auto& entry : fs::directory_iterator(fs::path(test::kProgram).parent_path().parent_path() / "lib")) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with("libscanknit_core.so")) fs::copy(fs::canonical(entry.path()), folder_ / name);
    }
  }

  Outcome run(const std::string& arguments) {
    const std::string folder = folder_.path().string();
    const std::string command = "cd '" + folder + "' && LD_LIBRARY_PATH='" + folder + "' ./scanknit " + arguments;
    const int status = std::system((command + " > out.txt 2> err.txt").c_str());
    return {WEXITSTATUS(status), read_text(folder_ / "out.txt"), read_text(folder_ / "err.txt")};
  }

  TempFolder folder_;
};

TEST_F(WithoutItsModule, ACommandSaysWhatIsMissing) {
  for (const auto& [arguments, module] :
       {std::pair("devices", "commands"), {"info nothing", "recording_commands"}, {"synth --list", "synth_commands"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(outcome.out, "");
    const std::string expected = std::string("error: the module libscanknit_") + module + ".so cannot be used: ";
    EXPECT_TRUE(outcome.err.starts_with(expected)) << outcome.err;
    EXPECT_NE(outcome.err.find("install ScanKnit again"), std::string::npos) << outcome.err;
  }
}

TEST_F(WithoutItsModule, WhatNeedsNoRoomWorks) {
  EXPECT_EQ(run("--version").out, scanknit_command({"--version"}).out);
  EXPECT_EQ(run("config print").out, scanknit_command({"config", "print"}).out);
  EXPECT_EQ(run("config check '" + std::string(test::kSourceDir) + "/configs/default.yaml'").exit_code, 0);
}

}  // namespace
}  // namespace scanknit
