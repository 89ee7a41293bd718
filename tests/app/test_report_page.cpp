#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <regex>

#include "app/report/report_json.h"
#include "export/picture/preview.h"
#include "export/report/report_page.h"
#include "tests/app/run_sample.h"
#include "tests/core/temporary_folder.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;
using test::write_text;

using Json = nlohmann::json;

/// A report without a turntable and finishing.
Json sample() {
  CommandRun run = test::sample_run();
  run.scan.turntable.reset();
  run.scan.mesh.finish.reset();
  return Json::parse(report_json(run));
}

constexpr const char* kTrajectory = "0 0 0 0 0 0 0 1\n1 0.5 0 0.1 0 0 0 1\n2 1 0 0.2 0 0 0 1\n";

std::string page_of(const Json& report, std::string_view trajectory = kTrajectory,
                    std::span<const PagePicture> pictures = {}) {
  const auto page = report_page(report.dump(-1, ' ', false, Json::error_handler_t::replace), trajectory, pictures);
  return page ? *page : "";
}

void expect_all(const std::string& page, const std::vector<const char*>& words) {
  for (const char* word : words) EXPECT_NE(page.find(word), std::string::npos) << word;
}

PagePicture png_of(const char* kind) {
  const TemporaryFolder folder;
  EXPECT_TRUE(write_png(ColourImage(1600, 400, {200, 60, 40}), folder / "p.png"));
  const std::string bytes = test::read_text(folder / "p.png");
  const auto raw = std::as_bytes(std::span(bytes));
  return {kind, {raw.begin(), raw.end()}};
}

TEST(ReportPage, TellsWhatTheReportTells) {
  expect_all(page_of(sample()),
             {"recordings/desk", "2000.0 × 2000.0 × 2000.0 mm", "1,200 of 1,234", "frame-000003.pose.txt: no such file",
              "<td>no_pose</td><td>30</td>", "<td>device</td><td>7</td>", "lost: too fast", "2 open rims, 300 mm",
              "<td>manifold</td><td>yes</td>", "2 min 5 s", "<td>integrate</td><td>2.50 s", "fusion.voxel_size",
              "out/model.glb", "median 1.10 mm", "1,924 × 1,020 texels, 99.3 % of them seen"});
}

TEST(ReportPage, DrawsTrackingAndTheCamerasWay) {
  const std::string page = page_of(sample());
  expect_all(page,
             {"<polyline class=\"overlap\"", "<rect class=\"lost\"", "<polyline class=\"path\"", "class=\"box\""});
  EXPECT_EQ(page_of(sample(), "").find("Camera path"), std::string::npos);
}

TEST(ReportPage, PosesOfScansAreNoWayOfACamera) {
  CommandRun run = test::sample_run();
  run.scan.alignment.emplace();
  const Json report = Json::parse(report_json(run));
  EXPECT_EQ(page_of(report).find("Camera path"), std::string::npos);
}

TEST(ReportPage, LostFramesStayVisibleAmongThousands) {
  CommandRun run = test::sample_run();
  run.scan.tracking->frames.assign(20'000, {1, TrackState::kOk, TrackReason::kNone, 0.9, 0.9, 1, 900, 0});
  run.scan.tracking->frames[12'345].state = TrackState::kLost;
  const std::string page = page_of(Json::parse(report_json(run)));
  EXPECT_NE(page.find("<rect class=\"lost\""), std::string::npos);
  EXPECT_LT(page.size(), 100'000u);
}

TEST(ReportPage, OfNothingIsAPage) {
  expect_all(page_of(Json::parse(report_json(CommandRun{})), ""), {"<!doctype html>", "There is no mesh", "</html>"});
}

TEST(ReportPage, OfAStreamedMeshSaysThatItsPictureIsCoarse) {
  CommandRun run = test::sample_run();
  run.scan.mesh.is_checked = false;
  run.scan.mesh.holes.reset();
  run.scan.mesh.fit.reset();
  const Json report = Json::parse(report_json(run));
  const std::vector<PagePicture> pictures = {png_of("preview")};
  expect_all(page_of(report, kTrajectory, pictures), {"<img", "never in memory as a whole", "coarsely", "not checked"});
  EXPECT_EQ(page_of(sample(), kTrajectory, pictures).find("coarsely"), std::string::npos);
  expect_all(page_of(report), {"There are no pictures", "not checked"});
}

TEST(ReportPage, NeedsNoScriptAndFetchesNothing) {
  const std::string page = page_of(sample());
  for (const char* word : {"<script", "http://", "https://", "url(", "src=\"/", "@import"}) {
    EXPECT_EQ(page.find(word), std::string::npos) << word;
  }
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

constexpr const char* kHostile = "<script>alert(1)</script>\"'&<img src=x onerror=y>\x01\xFF";

TEST(ReportPage, EveryNameInItsTemplateIsGivenAValue) {
  const std::filesystem::path folder = std::filesystem::path(test::kSourceDir) / "export/report";
  const std::string page = test::read_text(folder / "report.html.mustache");
  const std::string values = test::read_text(folder / "page_values.cpp");
  const std::regex tag(R"(\{\{[{#^]?(\w+)\}\})");
  std::size_t names = 0;
  for (auto match = std::sregex_iterator(page.begin(), page.end(), tag); match != std::sregex_iterator(); ++match) {
    const std::string name = (*match)[1];
    EXPECT_NE(values.find('"' + name + '"'), std::string::npos) << name;
    ++names;
  }
  EXPECT_GT(names, 100u);
}

TEST(ReportPage, EveryStringIsText) {
  CommandRun run = test::sample_run();
  run.scan.alignment.emplace().pairs.resize(1);
  Json report = Json::parse(report_json(run));
  const Json hostile = kHostile;
  report["input"] = report["version"] = report["status"] = hostile;
  report["warnings"] = {kHostile};
  report["frames"]["dropped_by_reason"] = {{kHostile, 1}};
  report["frames"]["drop_messages"] = {kHostile};
  report["losses"] = {{kHostile, 3}};
  report["tracking"]["frames"][1]["state"] = report["tracking"]["frames"][1]["reason"] = hostile;
  report["turntable"]["is_refined"] = false;
  report["turntable"]["reason"] = hostile;
  report["alignment"]["pairs"][0]["verdict"] = report["alignment"]["pairs"][0]["reason"] = hostile;
  report["stages"][kHostile] = report["stages"]["integrate"];
  report["files"] = {{kHostile, kHostile}};
  report["config"] = {{"<b>", "<i>\"'"}};
  const std::string page = page_of(report);
  for (const char* word : {"<script", "<img src=x", "<b>", "<i>\"", "\"'&<"}) {
    EXPECT_EQ(page.find(word), std::string::npos) << word;
  }
  expect_all(page, {"&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;&amp;&lt;img src=x", "&lt;b&gt;", "\xEF\xBF\xBD"});
  EXPECT_EQ(page.find('\x01'), std::string::npos);
  EXPECT_EQ(page.find('\xFF'), std::string::npos);
}

TEST(ReportPage, ALongTextIsCutBetweenCharacters) {
  CommandRun run = test::sample_run();
  run.scan.input.clear();
  for (int i = 0; i < 10'000; ++i) run.scan.input += "\xC3\xA9";  // é
  const std::string page = page_of(Json::parse(report_json(run)));
  EXPECT_NE(page.find("\xC3\xA9..."), std::string::npos);
  EXPECT_LT(page.size(), 50'000u);
}

TEST(ReportPage, PicturesAreWithinItAndShrunk) {
  const std::vector<PagePicture> pictures = {png_of("preview"), png_of("error"), png_of("coverage")};
  const std::string page = page_of(sample(), kTrajectory, pictures);
  std::size_t count = 0;
  for (std::size_t at = 0; (at = page.find("src=\"data:image/jpeg;base64,/9j/", at)) != std::string::npos; ++at)
    ++count;
  EXPECT_EQ(count, 3u);
}

TEST(ReportPage, WhatIsNoPictureIsLeftOut) {
  PagePicture broken = png_of("preview");
  broken.png.resize(40);
  PagePicture huge = png_of("error");
  for (std::size_t i = 16; i < 20; ++i) huge.png[i] = std::byte{0x7F};  // its width
  const std::vector<PagePicture> pictures = {broken, huge, {"coverage", {}}};
  const std::string page = page_of(sample(), kTrajectory, pictures);
  EXPECT_EQ(page.find("<img"), std::string::npos);
  EXPECT_NE(page.find("There are no pictures"), std::string::npos);
}

TEST(ReportPage, ValuesOfAnotherTypeAreLeftOut) {
  // A report of another version, or of somebody else: the page has what it understands.
  const nlohmann::json all = sample();
  for (const nlohmann::json& other :
       {nlohmann::json(), nlohmann::json("text"), nlohmann::json(7),
        nlohmann::json::array({1, "a", nlohmann::json::object()}), nlohmann::json{{"frames", 1}, {"pairs", 2}}}) {
    for (const auto& [key, value] : all.items()) {
      nlohmann::json changed = all;
      changed[key] = other;
      EXPECT_TRUE(report_page(changed.dump(), kTrajectory, {})) << key << " " << other;
      if (!value.is_object()) continue;
      for (const auto& [inner, ignored] : value.items()) {
        changed = all;
        changed[key][inner] = other;
        EXPECT_TRUE(report_page(changed.dump(), kTrajectory, {})) << key << "." << inner << " " << other;
      }
    }
  }
}

TEST(ReportPage, WhatIsNoReportIsRefused) {
  for (const std::string& text : {std::string(), std::string("[]"), std::string("{"), std::string("null"),
                                  "{\"a\":" + std::string(100'000, '[') + std::string(100'000, ']') + "}"}) {
    const auto page = report_page(text, "", {});
    ASSERT_FALSE(page) << text.substr(0, 20);
    EXPECT_EQ(page.error().code, ErrorCode::kInput);
  }
}

TEST(CheckReport, OursIsOneAndSoIsAnOlderOneThatHasLess) {
  nlohmann::json report = sample();
  EXPECT_TRUE(check_report(report.dump()));
  for (const char* key : {"alignment", "finish", "texture", "losses", "fit"}) report.erase(key);
  EXPECT_TRUE(check_report(report.dump()));
}

TEST(CheckReport, WhatLacksTheFirstThingsOrHasAnotherTypeIsNamed) {
  const auto said = [](const nlohmann::json& report) {
    const auto checked = check_report(report.dump());
    return checked ? std::string() : checked.error().message;
  };
  const nlohmann::json report = sample();
  EXPECT_NE(said(nlohmann::json::object()).find("version"), std::string::npos);
  EXPECT_NE(said(nlohmann::json::array()), "");
  for (const auto& [key, value] : report.items()) {
    nlohmann::json changed = report;
    changed[key] = value.is_string() ? nlohmann::json(1) : nlohmann::json("text");
    EXPECT_NE(said(changed).find("`" + key + "`"), std::string::npos) << key << ": " << said(changed);
  }
}

TEST(ReportPage, SaysHowMuchOfTheSurfaceIsThereTwice) {
  nlohmann::json report = sample();
  report["doubled"] = {{"area_m2", 0.25}, {"share", 0.125}};
  EXPECT_NE(page_of(report, "").find("<td>surface in two sheets</td><td>12.5 %</td>"), std::string::npos);
  report["doubled"] = nullptr;
  EXPECT_EQ(page_of(report, "").find("two sheets"), std::string::npos);
}

TEST(ReportPage, SaysHowWellSilhouettesAgree) {
  nlohmann::json report = sample();
  EXPECT_EQ(page_of(report, "").find("Silhouettes"), std::string::npos);
  report["silhouettes"] = {
      {"pictures", 36}, {"agreement", 0.9994}, {"worst_overlap", 0.975}, {"worst_picture", "masks/<7>.png"}};
  expect_all(page_of(report, ""), {"<td>36</td>", "<td>99.9 %</td>", "97.5 %, in masks/&lt;7&gt;.png"});
}

TEST(ReportPage, ATrajectoryThatIsNoneIsNoPath) {
  for (const char* text : {"nonsense", "1 2\n3 4\n", "0 nan 0 0\n1 inf 0 0\n", "0 1 2 3 0 0 0 1"}) {
    EXPECT_EQ(page_of(sample(), text).find("Camera path"), std::string::npos) << text;
  }
}

TEST(ReportPage, TheCamerasWayIsWhereFinishingPutTheMesh) {
  nlohmann::json report = sample();
  const std::string as_it_was = *report_page(report.dump(), kTrajectory, {});
  report["finish"] = {
      {"steps", {{{"name", "watertight"}, {"refused", ""}, {"figures", {{"invented_area_mm2", 20.04}}}}}},
      {"T_mesh_world", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, -5}, {0, 0, 0, 1}}}};
  const std::string moved = *report_page(report.dump(), kTrajectory, {});
  const auto path = [](const std::string& page) {
    const std::size_t begin = page.find("class=\"path\"");
    return page.substr(begin, page.find("/>", begin) - begin);
  };
  EXPECT_NE(path(moved), path(as_it_was));
  expect_all(moved, {"<td>watertight</td><td>invented area 20 mm2</td>"});
  report["finish"]["steps"][0] = {
      {"name", "smooth"}, {"refused", "interrupted"}, {"figures", nlohmann::json::object()}};
  expect_all(*report_page(report.dump(), kTrajectory, {}), {"<td>smooth</td><td>not done: interrupted</td>"});
  report["finish"]["T_mesh_world"][1] = "no row";
  EXPECT_EQ(path(*report_page(report.dump(), kTrajectory, {})), path(as_it_was));
}

TEST(ReportPage, FiguresOfFinishingAreRoundedForPeople) {
  nlohmann::json report = sample();
  report["finish"]["steps"] = {{{"name", "ground"},
                                {"refused", ""},
                                {"figures",
                                 {{"area_removed_mm2", 693027.2122655786},
                                  {"boundary_edges", 0.0},
                                  {"error_mm", 0.012345},
                                  {"invented_share", 0.120923},
                                  {"tilt_degrees", 1e-7},
                                  {"triangles", 38471.0}}}}};
  expect_all(
      *report_page(report.dump(), kTrajectory, {}),
      {"<td>ground</td><td>area removed 693,027 mm2<br>boundary edges 0<br>error 0.0123 mm<br>invented 12.1 %<br>"
       "tilt 0 degrees<br>triangles 38,471</td>"});
}

TEST(WriteReportPage, TakesWhatLiesBesideItWhereverTheRunWroteIt) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_png(ColourImage(64, 48, {200, 60, 40}), folder / "preview.png"));
  write_text(folder / "trajectory.txt", kTrajectory);
  Json report = sample();
  report["files"]["preview"] = "/elsewhere/out/preview.png";
  report["files"]["trajectory"] = "elsewhere/trajectory.txt";
  ASSERT_TRUE(write_report_page(report.dump(), folder / "report.html"));
  expect_all(test::read_text(folder / "report.html"), {"data:image/jpeg", "Camera path"});
}

TEST(WriteReportPage, ListsTheMeshOfEachClassWithItsPicture) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_png(ColourImage(64, 48, {200, 60, 40}), folder / "preview_class3.png"));
  Json report = sample();
  const Json mesh = report["mesh"];
  report["mesh"] = nullptr;
  report["classes"] = {
      {{"class", 3}, {"mesh", mesh}, {"area_m2", 0.01234}, {"files", {{"preview_class3", "out/preview_class3.png"}}}},
      {{"class", 12}, {"mesh", nullptr}, {"files", Json::object()}}};
  report["classes"][0]["mesh"]["components"] = 2;
  ASSERT_TRUE(write_report_page(report.dump(), folder / "report.html"));
  const std::string page = test::read_text(folder / "report.html");
  expect_all(page,
             {"<h2>Classes</h2>", "<td>3</td>", "<td>2</td>", "<td>123 cm2</td>", "alt=\"class 3\"",
              "<td>12</td><td>not known</td><td>not known</td><td>not known</td><td>not known</td><td>not known</td>"});
  EXPECT_EQ(page.find("alt=\"class 12\""), std::string::npos);
  EXPECT_EQ(page.find("There is no mesh"), std::string::npos);
}

TEST(WriteReportPage, ReadsNothingOutsideItsFolder) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "inner");
  ASSERT_TRUE(write_png(ColourImage(64, 48, {200, 60, 40}), folder / "secret.png"));
  Json report = sample();
  report["files"]["preview"] = "../secret.png";
  ASSERT_TRUE(write_report_page(report.dump(), folder / "inner" / "report.html"));
  EXPECT_EQ(test::read_text(folder / "inner" / "report.html").find("data:image"), std::string::npos);
}

TEST(WriteReportPage, LeavesTheOldPageWhenItCannotBeWritten) {
  const TemporaryFolder folder;
  write_text(folder / "report.html", "the old one");
  EXPECT_FALSE(write_report_page("no report", folder / "report.html"));
  EXPECT_EQ(test::read_text(folder / "report.html"), "the old one");
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
}  // namespace scanknit
