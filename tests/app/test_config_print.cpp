#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "app/config/config_load.h"
#include "app/config/config_print.h"
#include "app/config/config_schema.h"
#include "app/config/presets.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

std::string file_text(const std::string& name) {
  std::ifstream file(std::filesystem::path(test::kSourceDir) / name);
  return {std::istreambuf_iterator<char>(file), {}};
}

ScanConfig run_defaults() {
  return read_config({{"default"}, {}, {}})->config;
}

TEST(ConfigYaml, ReadsBackAsTheSameConfiguration) {
  ScanConfig unusual = load_config({{"tum_freiburg1", "phone_lidar"}, {}, {}})->config;
  unusual.noise.growth_per_m = 1.0 / 3.0;
  unusual.fusion.voxel_size_m = 0.0012345678901234567;
  unusual.fusion.memory_budget_mib = 1023;
  unusual.output.up = UpAxis::kMinusZ;
  for (const ScanConfig& config : {ScanConfig{}, run_defaults(), unusual}) {
    LoadedConfig loaded;
    const auto problems = apply_yaml(config_to_yaml(config), "printed.yaml", "", loaded);
    ASSERT_TRUE(problems.empty()) << problems.front().where << problems.front().message;
    const ScanConfig& back = loaded.config;
    for (const ConfigKey& key : config_schema()) {
      if (key.type == ConfigType::kIntrinsics) continue;
      EXPECT_EQ(key.get(back).index(), key.get(config).index()) << key.name;
    }
    EXPECT_EQ(config_to_json(back), config_to_json(config));
    EXPECT_EQ(config_to_yaml(back), config_to_yaml(config));
  }
}

TEST(ConfigYaml, KeepsNamesOfFilesWhateverTheirLetters) {
  for (const char* name : {"a b #c", "it's: here", "-", "null", "~", "[a]", "\"quoted\"", "plain/name-1.png"}) {
    ScanConfig config;
    config.acquire.masks = name;
    LoadedConfig loaded;
    ASSERT_TRUE(apply_yaml(config_to_yaml(config), "printed.yaml", "", loaded).empty()) << name;
    EXPECT_EQ(loaded.config.acquire.masks, name);
  }
}

TEST(ConfigYaml, OfTheRunDefaultsIsTheCommittedFile) {
  const std::string committed = file_text("configs/default.yaml");
  EXPECT_TRUE(committed.ends_with(config_to_yaml(run_defaults())))
      << "configs/default.yaml is out of date: keep its first line and append `scanknit config print`";
}

TEST(ConfigJson, IsOneObjectWithNumbersInBaseUnits) {
  const auto json = nlohmann::json::parse(config_to_json(ScanConfig{}));
  EXPECT_TRUE(json["fusion"]["voxel_size"].is_number());
  EXPECT_TRUE(json["fusion"]["noise"]["floor"].is_null());
  EXPECT_TRUE(json["acquire"]["depth_scale"].is_null());
  EXPECT_TRUE(json["export"]["formats"].is_array());
}

TEST(ConfigSchema, EveryKeyIsInTheJsonSchemaWithTextAndDefault) {
  const auto schema = nlohmann::json::parse(config_json_schema());
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  for (const ConfigKey& key : config_schema()) {
    std::string pointer = "/properties/" + key.name;
    for (std::size_t dot = pointer.find('.'); dot != std::string::npos; dot = pointer.find('.')) {
      pointer.replace(dot, 1, "/properties/");
    }
    const auto at = nlohmann::json::json_pointer(pointer);
    ASSERT_TRUE(schema.contains(at)) << key.name;
    EXPECT_TRUE(schema[at].contains("default")) << key.name;
    EXPECT_TRUE(schema[at].contains("description")) << key.name;
  }
}

TEST(ConfigSchema, DefaultsLieWithinTheirRanges) {
  for (const ConfigKey& key : config_schema()) {
    const ConfigValue value = key.get(built_in_config());
    const double* number = std::get_if<double>(&value);
    if (number == nullptr) continue;
    EXPECT_GE(*number, key.minimum) << key.name;
    EXPECT_LE(*number, key.maximum) << key.name;
  }
}

TEST(ConfigSchema, SettingWhatWasGotChangesNothing) {
  const ScanConfig config = load_config({{"icl_nuim"}, {}, {}})->config;
  ScanConfig copy = config;
  for (const ConfigKey& key : config_schema()) key.set(copy, key.get(config));
  EXPECT_EQ(config_to_json(copy), config_to_json(config));
}

TEST(ConfigDocs, TheCommittedPageIsUpToDate) {
  EXPECT_EQ(file_text("docs/configuration.md"), config_markdown(run_defaults()))
      << "run: scanknit config docs > docs/configuration.md";
}

}  // namespace
}  // namespace scanknit
