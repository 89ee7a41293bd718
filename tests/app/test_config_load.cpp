#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "app/config/config_load.h"
#include "app/config/config_print.h"
#include "app/config/presets.h"
#include "core/system/machine_memory.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// The problems as a user sees them, one a line.
std::string problems_of(const std::string& text, const fs::path& folder = "") {
  LoadedConfig loaded;
  std::string lines;
  for (const ConfigProblem& problem : apply_yaml(text, "a.yaml", folder, loaded)) {
    lines += problem.where + ": error: " + problem.message + "\n";
  }
  return lines;
}

ScanConfig config_of(const std::string& text) {
  LoadedConfig loaded;
  const auto problems = apply_yaml(text, "a.yaml", "", loaded);
  EXPECT_TRUE(problems.empty()) << problems.front().message;
  return loaded.config;
}

class TempFolder {
 public:
  TempFolder() : path_(fs::path(::testing::TempDir()) / ("scanknit_config_" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~TempFolder() { fs::remove_all(path_); }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return path_ / name;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

TEST(ConfigFile, SetsWhatItMentionsAndLeavesTheRest) {
  const ScanConfig config = config_of("fusion:\n  voxel_size: 2mm\n");
  EXPECT_EQ(config.fusion.voxel_size_m, 0.002);
  EXPECT_EQ(config.fusion.truncation_voxels, ScanConfig{}.fusion.truncation_voxels);
}

TEST(ConfigFile, ReadsEveryTypeOfValue) {
  const ScanConfig config = config_of(
      "acquire: {bilateral: true, min_confidence: 1, depth_scale: 5000, poses: still}\n"
      "fusion:\n  memory_budget: 2GiB\n  noise: {floor: 0.2 cm}\n"
      "extract: {placement: mid_edge}\n"
      "export: {formats: [stl, obj], up: -z}\n");
  EXPECT_TRUE(config.acquire.bilateral);
  EXPECT_EQ(config.acquire.min_confidence, 1);
  EXPECT_EQ(config.acquire.depth_scale, 5000.0);
  EXPECT_EQ(config.acquire.poses, PoseMode::kStill);
  EXPECT_EQ(config.fusion.memory_budget_mib, 2048u);
  EXPECT_EQ(config.fusion.noise.floor_m, 0.002);
  EXPECT_EQ(config.extract.placement, VertexPlacement::kMidEdge);
  EXPECT_EQ(config.output.formats, (std::vector<std::string>{"stl", "obj"}));
  EXPECT_EQ(config.output.up, UpAxis::kMinusZ);
}

TEST(ConfigFile, AutoGivesAKeyBackToTheRecording) {
  LoadedConfig loaded;
  loaded.config.acquire.depth_scale = 5000;
  EXPECT_TRUE(apply_yaml("acquire: {depth_scale: auto, intrinsics: auto}", "a.yaml", "", loaded).empty());
  EXPECT_FALSE(loaded.config.acquire.depth_scale);
}

TEST(ConfigFile, ASectionWithoutEntriesIsFine) {
  EXPECT_EQ(problems_of("fusion:\n# voxel_size: 2mm\n"), "");
  EXPECT_EQ(problems_of(""), "");
}

TEST(ConfigFile, SaysTheRangeAndGuessesMillimetres) {
  EXPECT_EQ(problems_of("fusion:\n  voxel_size: 2 m\n"),
            "a.yaml:2:15: error: fusion.voxel_size: 2 m is outside 0.0002..0.1 m (did you mean millimetres? 2 mm is "
            "0.002)\n");
}

TEST(ConfigFile, DoesNotGuessWhereMillimetresWouldNotFitEither) {
  EXPECT_EQ(problems_of("fusion: {voxel_size: 5000 m}"),
            "a.yaml:1:22: error: fusion.voxel_size: 5000 m is outside 0.0002..0.1 m\n");
}

TEST(ConfigFile, SuggestsTheKeyThatWasMeant) {
  EXPECT_EQ(problems_of("fusion:\n  voxel_sizee: 2mm\n"),
            "a.yaml:2:3: error: unknown key 'fusion.voxel_sizee'; did you mean 'fusion.voxel_size'?\n");
  EXPECT_EQ(problems_of("exprot: {}\n"), "a.yaml:1:1: error: unknown key 'exprot'; did you mean 'export'?\n");
}

TEST(ConfigFile, RefusesRepeatedKeys) {
  EXPECT_EQ(problems_of("fusion:\n  voxel_size: 2mm\n  voxel_size: 3mm\n"),
            "a.yaml:3:3: error: duplicate key 'fusion.voxel_size'\n");
  EXPECT_EQ(problems_of("fusion:\n  voxel_size: 2mm\nfusion: {}\n"), "a.yaml:3:1: error: duplicate key 'fusion'\n");
}

TEST(ConfigFile, SaysWhatWasExpectedOfEachType) {
  EXPECT_EQ(problems_of("fusion: {voxel_size: two}"),
            "a.yaml:1:22: error: fusion.voxel_size: expected a length such as 0.004, 4mm, 0.4 cm, got 'two'\n");
  EXPECT_EQ(problems_of("acquire: {bilateral: yes}"),
            "a.yaml:1:22: error: acquire.bilateral: expected true or false, got 'yes'\n");
  EXPECT_EQ(problems_of("acquire: {min_confidence: 1.5}"),
            "a.yaml:1:27: error: acquire.min_confidence: expected a whole number, got '1.5'\n");
  EXPECT_EQ(problems_of("fusion: {memory_budget: 2 GB}"),
            "a.yaml:1:25: error: fusion.memory_budget: expected memory such as 4GiB, 512MiB, got '2 GB'\n");
  EXPECT_EQ(problems_of("extract: {placement: linaer}"),
            "a.yaml:1:22: error: extract.placement: expected one of linear, mid_edge, got 'linaer'; did you mean "
            "'linear'?\n");
  EXPECT_EQ(problems_of("extract: {placement: [linear]}"),
            "a.yaml:1:22: error: extract.placement: expected one value\n");
  EXPECT_EQ(problems_of("fusion:\n  voxel_size:\n"), "a.yaml:2:3: error: fusion.voxel_size: expected a value\n");
  EXPECT_EQ(problems_of("fusion: 3\n"), "a.yaml:1:9: error: fusion: expected 'key: value' lines\n");
}

TEST(ConfigFile, RefusesNanAndInfinity) {
  EXPECT_EQ(problems_of("fusion: {truncation: nan}"),
            "a.yaml:1:22: error: fusion.truncation: expected a number, got 'nan'\n");
  EXPECT_EQ(problems_of("fusion: {truncation: .inf}"),
            "a.yaml:1:22: error: fusion.truncation: expected a number, got '.inf'\n");
}

TEST(ConfigFile, ChecksListsItemByItem) {
  EXPECT_EQ(problems_of("export:\n  formats: [glb, plx]\n"),
            "a.yaml:2:18: error: export.formats: expected one of glb, ply, obj, stl, 3mf, tiles, got 'plx'; did you "
            "mean 'ply'?\n");
  EXPECT_EQ(problems_of("export: {formats: [glb, glb]}"), "a.yaml:1:25: error: export.formats: 'glb' is there twice\n");
  EXPECT_EQ(problems_of("export: {formats: []}"),
            "a.yaml:1:19: error: export.formats: an empty list; expected some of glb, ply, obj, stl, 3mf, tiles\n");
}

TEST(ConfigFile, ReportsEveryErrorInOneGo) {
  const std::string lines = problems_of(
      "fusion:\n  voxel_sizee: 1\n  voxel_size: 2\n  truncation: two\nexprot:\n  formats: glb\nacquire: {poses: "
      "stil}\n");
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 5);
}

TEST(ConfigFile, KeysAtFaultKeepTheirValue) {
  LoadedConfig loaded;
  (void)apply_yaml("fusion: {voxel_size: 2 m, truncation: 5}", "a.yaml", "", loaded);
  EXPECT_EQ(loaded.config.fusion.voxel_size_m, ScanConfig{}.fusion.voxel_size_m);
  EXPECT_EQ(loaded.config.fusion.truncation_voxels, 5);
}

TEST(ConfigFile, SyntaxErrorsHaveTheirPlace) {
  EXPECT_EQ(problems_of("fusion:\n\tvoxel_size: 2mm\n"), "a.yaml:2:1: error: indented by a tab; YAML wants spaces\n");
  EXPECT_EQ(problems_of("fusion: {voxel_size: 2mm\n").substr(0, 7), "a.yaml:");
}

TEST(Intrinsics, ComeAsAList) {
  const ScanConfig config = config_of("acquire: {intrinsics: [481.2, -480, 319.5, 239.5]}");
  ASSERT_TRUE(config.acquire.intrinsics);
  EXPECT_EQ(config.acquire.intrinsics->intrinsics, (CameraIntrinsics{0, 0, 481.2, -480, 319.5, 239.5}));
}

TEST(Intrinsics, ComeAsAMapWithDistortion) {
  const ScanConfig config = config_of(
      "acquire:\n  intrinsics: {width: 640, height: 480, fx: 517.3, fy: 516.5, cx: 318.6, cy: 255.3, "
      "distortion: [0.26, -0.95, -0.005, 0.002, 1.16]}\n");
  ASSERT_TRUE(config.acquire.intrinsics);
  EXPECT_EQ(config.acquire.intrinsics->intrinsics.width, 640);
  EXPECT_EQ(config.acquire.intrinsics->distortion[4], 1.16);
}

TEST(Intrinsics, ComeFromAFileBesideTheConfiguration) {
  const TempFolder folder;
  folder.write("K.txt", "525 0 319.5\n0 526 239.5\n0 0 1\n");
  folder.write("camera.json",
               R"({"width": 640, "height": 480, "intrinsic_matrix": [525,0,0, 0,526,0, 319.5,239.5,1]})");
  for (const char* name : {"K.txt", "camera.json"}) {
    LoadedConfig loaded;
    const std::string text = std::string("acquire: {intrinsics: ") + name + "}";
    ASSERT_TRUE(apply_yaml(text, "a.yaml", folder.path(), loaded).empty()) << name;
    const ScanConfig& config = loaded.config;
    EXPECT_EQ(config.acquire.intrinsics->intrinsics.fx, 525) << name;
    EXPECT_EQ(config.acquire.intrinsics->intrinsics.fy, 526) << name;
    EXPECT_EQ(config.acquire.intrinsics->intrinsics.cx, 319.5) << name;
    EXPECT_EQ(config.acquire.intrinsics->intrinsics.cy, 239.5) << name;
  }
}

TEST(Intrinsics, SayWhatIsWrongWithThem) {
  EXPECT_EQ(problems_of("acquire: {intrinsics: [525, 525, 319.5]}"),
            "a.yaml:1:23: error: acquire.intrinsics: expected a list of 4 numbers\n");
  EXPECT_EQ(problems_of("acquire: {intrinsics: [525, nan, 319.5, 239.5]}"),
            "a.yaml:1:29: error: acquire.intrinsics: expected a number, got 'nan'\n");
  EXPECT_EQ(problems_of("acquire: {intrinsics: [0, 525, 319.5, 239.5]}"),
            "a.yaml:1:23: error: acquire.intrinsics: fx and fy must not be 0\n");
  EXPECT_EQ(problems_of("acquire: {intrinsics: {fx: 1, fy: 1, cx: 1}}"),
            "a.yaml:1:23: error: acquire.intrinsics: 'cy' is missing\n");
  EXPECT_EQ(problems_of("acquire: {intrinsics: {fx: 1, fx: 2, fy: 1, cx: 1, cy: 1}}"),
            "a.yaml:1:31: error: acquire.intrinsics: duplicate key 'fx'\n");
  EXPECT_EQ(problems_of("acquire: {intrinsics: {width: 640, fx: 1, fy: 1, cx: 1, cy: 1}}"),
            "a.yaml:1:23: error: acquire.intrinsics: width and height: give both or neither\n");
  EXPECT_NE(problems_of("acquire: {intrinsics: missing.txt}").find("no such file"), std::string::npos);
}

TEST(Assignment, TakesAnyYamlValue) {
  LoadedConfig loaded;
  EXPECT_TRUE(apply_assignment("fusion.voxel_size=2mm", loaded).empty());
  EXPECT_TRUE(apply_assignment("export.formats=[glb, stl]", loaded).empty());
  EXPECT_TRUE(apply_assignment("acquire.intrinsics=[1, 2, 3, 4]", loaded).empty());
  const ScanConfig& config = loaded.config;
  EXPECT_EQ(config.fusion.voxel_size_m, 0.002);
  EXPECT_EQ(config.output.formats.size(), 2u);
  EXPECT_EQ(config.acquire.intrinsics->intrinsics.fy, 2);
}

TEST(Assignment, SaysWhatIsWrongWithIt) {
  LoadedConfig loaded;
  const auto message = [&](const std::string& assignment) {
    const auto problems = apply_assignment(assignment, loaded);
    return problems.empty() ? "" : problems.front().where + ": " + problems.front().message;
  };
  EXPECT_EQ(message("fusion.voxel_size"),
            "--set fusion.voxel_size: expected key=value, for instance fusion.voxel_size=2mm");
  EXPECT_EQ(message("fusion.voxelsize=2mm"),
            "--set fusion.voxelsize=2mm: unknown key 'fusion.voxelsize'; did you mean 'fusion.voxel_size'?");
  EXPECT_EQ(message("finish.crop={min_x: 1m, max_x: 2m}"), "");
  EXPECT_EQ(message("finish.crop=[1, 2]"), "--set finish.crop=[1, 2]: finish.crop: expected 'key: value' lines");
  EXPECT_EQ(
      message("fusion.voxel_size=2"),
      "--set fusion.voxel_size=2: fusion.voxel_size: 2 m is outside 0.0002..0.1 m (did you mean millimetres? 2 mm "
      "is 0.002)");
}

TEST(Precedence, AssignmentsBeatTheFileWhichBeatsPresetsWhichBeatDefaults) {
  const TempFolder folder;
  ConfigSources sources;
  EXPECT_EQ(load_config(sources)->config.fusion.voxel_size_m, ScanConfig{}.fusion.voxel_size_m);
  sources.presets = {"object"};
  EXPECT_EQ(load_config(sources)->config.fusion.voxel_size_m, 0.002);
  sources.presets = {"object", "room"};
  EXPECT_EQ(load_config(sources)->config.fusion.voxel_size_m, 0.01);
  sources.file = folder.write("mine.yaml", "fusion: {voxel_size: 5mm}");
  EXPECT_EQ(load_config(sources)->config.fusion.voxel_size_m, 0.005);
  sources.assignments = {"fusion.voxel_size=6mm", "fusion.voxel_size=7mm"};
  EXPECT_EQ(load_config(sources)->config.fusion.voxel_size_m, 0.007);
}

TEST(AutomaticBudget, IsOfThisMachineOnceTheProgramWorks) {
  EXPECT_EQ(read_config({})->config.fusion.memory_budget_mib, 0u) << "auto";
  const auto loaded = load_config({});
  EXPECT_EQ(loaded->config.fusion.memory_budget_mib, default_memory_budget_mib(machine_memory_mib()));
  EXPECT_EQ(loaded->config.extract.memory_budget_mib, loaded->config.fusion.memory_budget_mib);
}

TEST(AutomaticBudget, OfVolumeFilesIsTheOneThatIsGivenForScans) {
  const auto loaded = load_config({{}, {}, {"fusion.memory_budget=512MiB"}});
  EXPECT_EQ(loaded->config.fusion.memory_budget_mib, 512u);
  EXPECT_EQ(loaded->config.extract.memory_budget_mib, 512);
  EXPECT_EQ(load_config({{}, {}, {"extract.memory_budget=1GiB"}})->config.extract.memory_budget_mib, 1024);
}

TEST(GivenKeys, AreThoseOfPresetsTheFileAndAssignments) {
  const TempFolder folder;
  ConfigSources sources;
  EXPECT_TRUE(load_config(sources)->given.empty());
  sources.presets = {"icl_nuim"};
  EXPECT_EQ(load_config(sources)->given,
            (std::set<std::string, std::less<>>{"acquire.depth_scale", "acquire.intrinsics"}));
  sources.presets.clear();
  sources.file = folder.write("given.yaml", "fusion:\n  noise: {floor: 2 mm}\n# extract: {isovalue: 0}\n");
  sources.assignments = {"finish.crop={min_x: 1m}"};
  EXPECT_EQ(load_config(sources)->given,
            (std::set<std::string, std::less<>>{"finish.crop.min_x", "fusion.noise.floor"}));
}

TEST(GivenKeys, HoldAValueThatIsTheBuiltInOne) {
  const auto loaded = load_config({{}, {}, {"extract.isovalue=0"}});
  EXPECT_TRUE(loaded->gives("extract.isovalue"));
  EXPECT_FALSE(loaded->gives("extract.inside"));
}

TEST(GivenKeys, HoldNothingOfTheRunDefaults) {
  ConfigSources sources;
  sources.starts_from_run_defaults = true;
  EXPECT_TRUE(load_config(sources)->given.empty());
  EXPECT_GT(load_config(sources)->config.extract.min_component_triangles, 0u) << "configs/default.yaml was applied";
  sources.assignments = {"fusion.voxel_size=2mm"};
  EXPECT_TRUE(load_config(sources)->gives("fusion.voxel_size"));
  EXPECT_EQ(load_config(sources)->given.size(), 1u);
}

TEST(AskedKeys, AreThoseThatASettingGivesWhateverTheValue) {
  const auto loaded = load_config(with_run_defaults({{}, {}, {"finish.max_hole=20mm"}}));
  EXPECT_EQ(loaded->asked, (std::set<std::string, std::less<>>{"finish.max_hole"}));
}

TEST(AskedKeys, OfAPartOfASectionAreAllThatItGives) {
  const TempFolder folder;
  ConfigSources sources;
  sources.file = folder.write("part.yaml", "finish: {watertight: full, max_hole: 20 mm}\n");
  EXPECT_EQ(load_config(sources)->asked, (std::set<std::string, std::less<>>{"finish.max_hole", "finish.watertight"}));
}

TEST(AskedKeys, OfAWholeSectionAreThoseWithAnotherValueThanTheBuiltInOne) {
  const TempFolder folder;
  ScanConfig edited = built_in_config();
  edited.finish.watertight = Watertight::kFull;
  ConfigSources sources;
  sources.file = folder.write("whole.yaml", config_to_yaml(edited));
  const auto loaded = load_config(sources);
  EXPECT_EQ(loaded->asked, (std::set<std::string, std::less<>>{"finish.watertight"}));
  EXPECT_TRUE(loaded->gives("finish.max_hole"));
  sources.assignments = {"finish.max_hole=20mm"};
  EXPECT_TRUE(load_config(sources)->asks_for("finish.max_hole"));
}

TEST(AskedKeys, OfAPresetAreThoseWithAnotherValueThanTheBuiltInOne) {
  const auto loaded = load_config({{"turntable"}, {}, {}});
  EXPECT_TRUE(loaded->asks_for("turntable.enabled"));
  EXPECT_TRUE(loaded->gives("export.material"));
  EXPECT_FALSE(loaded->asks_for("export.material"));
}

TEST(LoadConfig, FailsWithALineForEveryProblemOfEverySource) {
  const auto config = load_config({{"objct"}, "/nowhere/a.yaml", {"fusion.voxel_size=0"}});
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error().code, ErrorCode::kConfig);
  const std::string& text = config.error().message;
  EXPECT_NE(text.find("--preset objct: error: no such preset"), std::string::npos) << text;
  EXPECT_NE(text.find("did you mean 'object'?"), std::string::npos) << text;
  EXPECT_NE(text.find("/nowhere/a.yaml: error: no such file"), std::string::npos) << text;
  EXPECT_NE(text.find("--set fusion.voxel_size=0: error: fusion.voxel_size: 0 m is outside"), std::string::npos)
      << text;
}

TEST(LoadConfig, RefusesADepthRangeThatLeavesNothing) {
  EXPECT_FALSE(load_config({{}, {}, {"acquire.min_depth=2m", "acquire.max_depth=1m"}}));
}

TEST(LoadConfig, RefusesAFileBeyondTheLimit) {
  const TempFolder folder;
  const auto config = load_config({{}, folder.write("big.yaml", std::string(Limits{}.max_config_bytes + 1, '#')), {}});
  ASSERT_FALSE(config);
  EXPECT_NE(config.error().message.find("more than the limit"), std::string::npos);
}

TEST(Presets, AllAreWithoutErrors) {
  EXPECT_GE(presets().size(), 8u);
  for (const Preset& preset : presets()) {
    const auto config = load_config({{std::string(preset.name)}, {}, {}});
    EXPECT_TRUE(config) << config.error().message;
  }
}

TEST(ConfigTopics, AreNamedInAMapOrOneByOne) {
  const ScanConfig config = config_of("acquire:\n  topics: {depth: /cam/depth/image_raw, colour: none}\n");
  EXPECT_EQ(config.acquire.topics.depth, "/cam/depth/image_raw");
  EXPECT_EQ(config.acquire.topics.colour, "none");
  EXPECT_FALSE(config.acquire.topics.poses) << "auto";
  EXPECT_FALSE(config_of("acquire: {topics: {depth: auto}}").acquire.topics.depth);
}

TEST(ConfigTopics, ThatAreNoNamesAreRefused) {
  EXPECT_NE(problems_of("acquire: {topics: {depth: 'a b'}}")
                .find("acquire.topics.depth: expected the name of a topic such as /camera/depth/image_raw, got 'a b'"),
            std::string::npos);
  EXPECT_NE(problems_of("acquire: {topics: {dept: /a}}").find("did you mean 'acquire.topics.depth'?"),
            std::string::npos);
}

}  // namespace
}  // namespace scanknit
