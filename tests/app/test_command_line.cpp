// Usage, help, configuration commands, exit codes.
#include <gtest/gtest.h>

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/version.h"
#include "tests/app/program.h"
#include "tests/app/scan.h"
#include "tests/support/places.h"
#include "tests/support/text.h"

namespace scanknit {
namespace {

using test::contains;

TEST(CommandLine, AloneItPrintsHelp) {
  const Outcome outcome = scanknit_command({});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.out, "run"));
  EXPECT_TRUE(contains(outcome.out, "Exit codes"));
}

TEST(CommandLine, HelpAndVersionGoToStdout) {
  EXPECT_EQ(scanknit_command({"--version"}).out, std::string("scanknit ") + kVersion + "\n");
  const Outcome help = scanknit_command({"run", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_TRUE(contains(help.out, "--save-volume"));
}

TEST(CommandLine, UsageErrorsExitWith2AndSayWhatWasMeant) {
  const Outcome typo = scanknit_command({"rnu", "somewhere"});
  EXPECT_EQ(typo.exit_code, 2);
  EXPECT_TRUE(contains(typo.err, "Did you mean scanknit run?")) << typo.err;
  EXPECT_EQ(typo.out, "");
  EXPECT_EQ(scanknit_command({"run"}).exit_code, 2);
  EXPECT_EQ(scanknit_command({"run", "rec"}).exit_code, 2);
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--every", "0"}).exit_code, 2);
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--from", "-1"}).exit_code, 2);
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--threads", "0"}).exit_code, 2);
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--nonsense"}).exit_code, 2);
  EXPECT_EQ(scanknit_command({"synth", "sphere"}).exit_code, 2);
  EXPECT_EQ(scanknit_command({"config"}).exit_code, 2);
}

TEST(CommandLine, RefusesAnOutputOfAnUnknownKind) {
  const Outcome outcome = scanknit_command({"run", "rec", "-o", "model.fbx"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(contains(outcome.err, ".glb, .ply, .obj, .stl, .3mf or .tiles")) << outcome.err;
}

TEST(CommandLine, ConfigErrorsExitWith3OnePerLine) {
  const TempFolder folder;
  const std::string file = (folder / "a.yaml").string();
  std::ofstream(file) << "fusion:\n  voxel_size: 2 m\nexprot: {}\n";
  const Outcome outcome = scanknit_command({"config", "check", file});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.err, file +
                             ":2:15: error: fusion.voxel_size: 2 m is outside 0.0002..0.1 m (did you mean millimetres? "
                             "2 mm is 0.002)\n" +
                             file + ":3:1: error: unknown key 'exprot'; did you mean 'export'?\n");
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--set", "fusion.voxel_size=0"}).exit_code, 3);
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--poses", "guess"}).exit_code, 3);
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--preset", "nope"}).exit_code, 3);
  EXPECT_EQ(scanknit_command({"run", "rec", "-o", "out", "--config", "/nowhere.yaml"}).exit_code, 3);
}

TEST(CommandLine, EveryCommittedConfigurationPassesConfigCheck) {
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(test::kSourceDir) / "configs")) {
    if (entry.path().extension() != ".yaml") continue;
    const Outcome outcome = scanknit_command({"config", "check", entry.path().string()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
}

TEST(CommandLine, ThePrintedConfigurationPassesConfigCheck) {
  const TempFolder folder;
  const std::string file = (folder / "printed.yaml").string();
  for (const char* defaults : {"", "--defaults"}) {
    std::vector<std::string> arguments = {"config", "print", "--set", "fusion.voxel_size=3mm"};
    if (*defaults != '\0') arguments.emplace_back(defaults);
    const Outcome printed = scanknit_command(arguments);
    EXPECT_TRUE(contains(printed.out, "voxel_size: 3 mm"));
    std::ofstream(file) << printed.out;
    EXPECT_EQ(scanknit_command({"config", "check", file}).exit_code, 0);
  }
}

TEST(CommandLine, SchemaAndJsonConfigurationAreJson) {
  EXPECT_TRUE(nlohmann::json::accept(scanknit_command({"config", "schema"}).out));
  EXPECT_TRUE(nlohmann::json::accept(scanknit_command({"config", "print", "--json"}).out));
}

TEST(CommandLine, UnreadableInputsExitWith4) {
  const TempFolder folder;
  const std::string out = (folder / "out").string();
  EXPECT_EQ(scanknit_command({"run", "/nowhere", "-o", out}).exit_code, 4);
  EXPECT_EQ(scanknit_command({"info", "/nowhere"}).exit_code, 4);
  EXPECT_EQ(scanknit_command({"info", "/nowhere.ply"}).exit_code, 4);
  EXPECT_EQ(scanknit_command({"extract", "/nowhere.vdb", "-o", out}).exit_code, 4);
  EXPECT_EQ(scanknit_command({"distance", "/nowhere.ply", "/nowhere"}).exit_code, 4);
}

TEST(CommandLine, TimesAndRatesAreFiniteNumbers) {
  const TempFolder folder;
  for (const char* command : {"capture", "record"}) {
    for (const char* option : {"--seconds", "--wait", "--reconnect", "--fps"}) {
      for (const char* value : {"nan", "-nan", "inf"}) {
        const Outcome outcome = scanknit_command({command, "-o", (folder / "scan.mcap").string(), option, value});
        EXPECT_EQ(outcome.exit_code, 2) << command << ' ' << option << ' ' << value << ": " << outcome.err;
      }
    }
  }
}

TEST(CommandLine, ARecordingIsNamedMcap) {
  const TempFolder folder;
  for (const char* name : {"k.txt", "k", "k.mcap.gz", ".mcap"}) {
    const std::string file = (folder / name).string();
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"record", "-o", file},
          std::vector<std::string>{"capture", "-o", (folder / "out").string(), "--recording", file},
          std::vector<std::string>{"convert", "scan", "--to", "mcap", "-o", file},
          std::vector<std::string>{"repair", "scan.mcap", "-o", file}}) {
      const Outcome outcome = scanknit_command(command);
      EXPECT_EQ(outcome.exit_code, 2) << command[0] << ' ' << name << ": " << outcome.err;
      EXPECT_TRUE(contains(outcome.err, file + ": no such output: give a file that ends in .mcap")) << outcome.err;
    }
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(CommandLine, SynthListsItsScenes) {
  const Outcome outcome = scanknit_command({"synth", "--list"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.out, "sphere\n"));
  EXPECT_EQ(scanknit_command({"synth", "no_such_scene", "-o", "/tmp/never"}).exit_code, 2);
}

TEST(CommandLine, ShorthandsStandBesideSet) {
  const Scan scan;
  const Outcome outcome = scan.run({"--poses", "nonsense"});  // run() itself says --set
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.err.find("acquire.poses"), std::string::npos) << outcome.err;
}

TEST(CommandLine, AnEmptyOutputIsAUsageError) {
  EXPECT_EQ(scanknit_command({"run", "anything", "-o", ""}).exit_code, 2);
}

TEST(CommandLine, AResultThatStdoutWillNotTakeExitsWith8) {
  for (const std::string command : {"config schema", "config print", "synth --list"}) {
    const int status = std::system((test::kProgram + " " + command + " > /dev/full 2> /dev/null").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 8) << command;
  }
}

TEST(CommandLine, DistanceMeasuresGlbAndStlAsItDoesPly) {
  const Scan scan;
  ASSERT_EQ(scan.run({"--set", "export.formats=[glb,ply,stl]"}).exit_code, 0);
  const auto mean_m = [&](const std::string& name) {
    const Outcome outcome =
        scanknit_command({"distance", (scan.output() / name).string(), scan.recording().string(), "--json"});
    return nlohmann::json::parse(outcome.out)["area"]["mean_m"].get<double>();
  };
  constexpr double kSampling = 1e-5;  // the order of triangles decides where the samples lie
  EXPECT_NEAR(mean_m("model.glb"), mean_m("model.ply"), kSampling);
  EXPECT_NEAR(mean_m("model.stl"), mean_m("model.ply"), kSampling);
}

}  // namespace
}  // namespace scanknit
