#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "app/report/report_json.h"
#include "export/measure/mesh_stats.h"
#include "tests/app/run_sample.h"
#include "tests/core/temporary_folder.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

using Json = nlohmann::json;

bool has_type(const Json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  return type == "null" && value.is_null();
}

/// The part of JSON Schema that docs/report.schema.json uses; adds what is wrong to `faults`.
void validate(const Json& value, const Json& schema, const std::string& place, std::vector<std::string>& faults) {
  if (schema.is_boolean()) {
    if (!schema.get<bool>()) faults.push_back(place + " is not allowed");
    return;
  }
  if (schema.contains("type")) {
    const Json types = schema["type"].is_array() ? schema["type"] : Json::array({schema["type"]});
    if (std::none_of(types.begin(), types.end(), [&](const Json& type) { return has_type(value, type); })) {
      faults.push_back(place + " is not of type " + types.dump());
      return;
    }
  }
  if (value.is_object()) {
    for (const Json& key : schema.value("required", Json::array())) {
      if (!value.contains(key.get<std::string>())) faults.push_back(place + " lacks " + key.dump());
    }
    const Json properties = schema.value("properties", Json::object());
    for (const auto& [key, member] : value.items()) {
      const Json fallback = schema.contains("additionalProperties") ? schema["additionalProperties"] : Json(true);
      validate(member, properties.contains(key) ? properties[key] : fallback, place + "." + key, faults);
    }
  }
  if (value.is_array()) {
    if (value.size() < schema.value("minItems", 0u) || value.size() > schema.value("maxItems", 1'000'000u)) {
      faults.push_back(place + " has the wrong length");
    }
    for (const Json& item : value) validate(item, schema.value("items", Json(true)), place + "[]", faults);
  }
}

std::vector<std::string> faults_of(const std::string& report) {
  static const Json schema = Json::parse(test::read_text(test::kSourceDir + "/docs/report.schema.json"));
  std::vector<std::string> faults;
  validate(Json::parse(report), schema, "report", faults);
  return faults;
}

using test::sample_run;

TEST(Report, FollowsItsPublishedSchema) {
  EXPECT_EQ(faults_of(report_json(sample_run())), std::vector<std::string>{});
}

TEST(Report, OfNothingFollowsTheSchemaToo) {
  EXPECT_EQ(faults_of(report_json(CommandRun{})), std::vector<std::string>{});
}

TEST(Report, SchemaTestSeesWhatIsWrong) {
  Json json = Json::parse(report_json(sample_run()));
  json["frames"]["read"] = "ten";
  json["mesh"].erase("euler");
  json["surprise"] = 1;
  EXPECT_EQ(faults_of(json.dump()).size(), 3u);
}

TEST(Report, EveryKeyIsInItsTable) {
  const std::string table = test::read_text(test::kSourceDir + "/docs/report.md");
  const Json json = Json::parse(report_json(sample_run()));
  for (const char* part : {"frames", "tracking", "volume", "mesh", "holes", "fit", "extract", "finish", "texture"}) {
    for (const auto& [key, value] : json[part].items()) {
      EXPECT_NE(table.find("`" + std::string(part) + "." + key + "`"), std::string::npos) << key;
    }
  }
  for (const auto& [key, value] : json["tracking"]["frames"][0].items()) {
    EXPECT_NE(table.find("`tracking.frames[]." + key + "`"), std::string::npos) << key;
  }
  for (const auto& [key, value] : json.items()) EXPECT_NE(table.find("`" + key), std::string::npos) << key;
}

TEST(Report, NumbersAreTheNumbers) {
  const Json json = Json::parse(report_json(sample_run()));
  EXPECT_EQ(json["frames"]["dropped_by_reason"]["no_pose"], 30);
  EXPECT_EQ(json["stages"]["integrate"]["total_ms"], 2500.0);
  EXPECT_EQ(json["mesh"]["euler"], 2);
  EXPECT_EQ(json["mesh"]["bounds_m"], Json::parse("[[-1,-1,-1],[1,1,1]]"));
  EXPECT_EQ(json["config"]["fusion"]["voxel_size"], 0.004);
}

TEST(Report, BoundsArePrintedWithTheDigitsTheyHave) {
  MeshCheck check;
  check.max_m = {0.1f, 1.0f / 3, 2};
  EXPECT_NE(mesh_check_json(check).find("[0.1,0.33333334,2.0]"), std::string::npos);
}

TEST(Report, WithoutAMeshSaysNull) {
  CommandRun run = sample_run();
  run.scan.mesh.check.reset();
  EXPECT_TRUE(Json::parse(report_json(run))["mesh"].is_null());
}

TEST(Report, CountsEveryStateOfTracking) {
  const Json tracking = Json::parse(report_json(sample_run()))["tracking"];
  EXPECT_EQ(tracking["states"], Json::parse(R"({"ok": 2, "weak": 0, "lost": 1, "recovered": 0})"));
  EXPECT_EQ(tracking["frames"][2]["reason"], "too fast");
  EXPECT_TRUE(Json::parse(report_json(CommandRun{}))["tracking"].is_null());
}

TEST(Report, TextThatIsNotUtf8IsRepaired) {
  CommandRun run = sample_run();
  run.scan.input = "caf\xE9/\xFF\xFE";
  run.scan.frames.dropped_by_reason["\xC3\x28"] = 1;
  run.scan.frames.drop_messages = {"\x80"};
  run.scan.files["\xE9"] = "\xE9";
  EXPECT_EQ(faults_of(report_json(run)), std::vector<std::string>{});
}

TEST(Report, NaNNeverAppears) {
  CommandRun run = sample_run();
  run.total_ms = std::numeric_limits<double>::quiet_NaN();
  run.scan.stages["track"].samples_ms = {std::numeric_limits<double>::infinity()};
  run.scan.mesh.check->max_m.x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(faults_of(report_json(run)), std::vector<std::string>{});
}

TEST(Report, KeepsTheFirstHundredDropMessages) {
  CommandRun run = sample_run();
  run.scan.frames.drop_messages.assign(250, "a frame");
  EXPECT_EQ(Json::parse(report_json(run))["frames"]["drop_messages"].size(), 100u);
}

TEST(Report, WarningsThatRepeatItsNumbersAreLeftOut) {
  EXPECT_EQ(Json::parse(report_json(sample_run()))["warnings"], Json::array({"no data for 333 ms"}));
}

TEST(Report, EndsInANewline) {
  EXPECT_TRUE(report_json(sample_run()).ends_with("}\n"));
}

TEST(StageTimes, MedianIsTheMiddleOrTheMeanOfTheTwo) {
  EXPECT_EQ((StageTimes{{3, 1, 2}}.median_ms()), 2);
  EXPECT_EQ((StageTimes{{4, 1, 3, 2}}.median_ms()), 2.5);
}

TEST(StageTimes, P95IsTheNearestRank) {
  StageTimes times;
  for (int i = 1; i <= 100; ++i) times.samples_ms.push_back(i);
  EXPECT_EQ(times.p95_ms(), 95);
  EXPECT_EQ((StageTimes{{7}}.p95_ms()), 7);
}

TEST(StageTimes, WithoutSamplesAreZero) {
  EXPECT_EQ(StageTimes{}.median_ms(), 0);
  EXPECT_EQ(StageTimes{}.p95_ms(), 0);
  EXPECT_EQ(StageTimes{}.total_ms(), 0);
}

}  // namespace
}  // namespace scanknit
