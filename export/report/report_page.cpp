#include "export/report/report_page.h"

#include <fmt/format.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/files/atomic_file.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "export/report/page_pictures.h"
#include "export/report/page_sections.h"

namespace scanknit {
namespace {

constexpr int kPictureColumns = 1280;
constexpr int kPairColumns = 560;
constexpr std::size_t kMostPairs = 12;
constexpr std::uintmax_t kMostPictureBytes = 32u << 20;

// Nothing is fetched, and no script would run: whatever a report's strings hold, they are text.
constexpr std::string_view kHead = R"html(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<title>ScanKnit report</title>
<style>
:root {
  color-scheme: light dark;
  --page: #f6f6f4; --card: #fff; --ink: #1c1e21; --faint: #5b6067; --line: #dcdcd8;
  --good: #1d7a46; --bad: #b3261e; --accent: #2a6fb0; --warm: #c4701a;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #131416; --card: #1d1f22; --ink: #e8e8e6; --faint: #a2a7ad; --line: #35383c;
    --good: #5fc58a; --bad: #f2877f; --accent: #6fb1ee; --warm: #eba35a;
  }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 60rem; padding: 1rem; background: var(--page); color: var(--ink);
  font: 16px/1.5 system-ui, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.4rem; margin: 0; }
h2 { font-size: 1.1rem; margin: 0 0 .6rem; }
p { margin: .4rem 0; }
header, section { background: var(--card); border: 1px solid var(--line); border-radius: .6rem; padding: 1rem; margin: 0 0 1rem; }
.input, footer { color: var(--faint); }
.status { font-weight: 600; white-space: pre-line; }
.good { color: var(--good); }
.bad, strong { color: var(--bad); }
dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)); gap: .8rem; margin: 1rem 0 0; }
dt { color: var(--faint); font-size: .85rem; }
dd { margin: 0; font-weight: 600; font-variant-numeric: tabular-nums; }
.scroll { overflow-x: auto; margin: .6rem 0; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: .92rem; }
th, td { text-align: left; vertical-align: top; padding: .25rem .8rem .25rem 0; border-bottom: 1px solid var(--line);
  unicode-bidi: isolate; min-width: 3.6rem; }
td:first-child { min-width: 5.4rem; }
th { color: var(--faint); font-weight: 500; }
ul { padding-left: 1.2rem; }
figure { margin: 0 0 1rem; }
figcaption, .legend, .axis { color: var(--faint); font-size: .88rem; }
img { display: block; width: 100%; height: auto; border-radius: .4rem; margin-bottom: .3rem; }
svg { display: block; width: 100%; background: var(--page); border-radius: .4rem; }
.chart { height: 11rem; }
.axis { display: flex; justify-content: space-between; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(15rem, 1fr)); gap: 1rem; }
polyline, path, .box { fill: none; vector-effect: non-scaling-stroke; stroke-width: 1.5; }
.grid { stroke: var(--line); }
.box { stroke: var(--faint); stroke-dasharray: 4 3; }
polyline.path, polyline.overlap { stroke: var(--accent); }
polyline.inliers { stroke: var(--warm); }
circle.first, rect.ok { fill: var(--good); }
circle.last, rect.lost { fill: var(--bad); }
rect.recovered { fill: var(--accent); }
rect.weak { fill: var(--warm); }
i { display: inline-block; width: .9rem; height: .7rem; margin: 0 .3rem 0 .7rem; border-radius: .15rem; }
i:first-child { margin-left: 0; }
i.overlap, i.recovered { background: var(--accent); }
i.inliers, i.weak { background: var(--warm); }
i.ok, i.first { background: var(--good); }
i.lost, i.last { background: var(--bad); }
i.overlap, i.inliers { height: .2rem; vertical-align: middle; }
.ramp i { width: 7rem; margin: 0 .4rem; }
.bar { display: block; height: .35rem; background: var(--accent); border-radius: .15rem; }
summary { cursor: pointer; padding: .4rem 0; }
</style>
</head>
<body>
)html";

using Json = nlohmann::ordered_json;

Result<Json> parse(std::string_view report_json) {
  constexpr int kMostDepth = 64;
  bool is_too_deep = false;
  const auto watch = [&](int depth, Json::parse_event_t, Json&) {
    is_too_deep = is_too_deep || depth > kMostDepth;
    return !is_too_deep;
  };
  Json json = Json::parse(report_json, watch, /*allow_exceptions=*/false);
  if (is_too_deep || !json.is_object()) return Error{ErrorCode::kInput, "is no report: expected a JSON object"};
  return json;
}

PageUris uris_of(std::span<const PagePicture> pictures) {
  PageUris uris;
  for (const PagePicture& picture : pictures) {
    const bool is_pair = picture.kind.starts_with("pair ");
    uris[picture.kind] = picture_uri(picture.png, is_pair ? kPairColumns : kPictureColumns);
  }
  return uris;
}

/// The file in `folder` that a report names, wherever it was when the report was written; empty when it is not there.
std::string bytes_beside(const std::filesystem::path& folder, const std::string& named, std::uintmax_t most) {
  const std::filesystem::path name = std::filesystem::path(named).filename();
  if (name.empty() || name == "." || name == "..") return "";
  auto bytes = read_text_file(folder / name, most);
  return bytes ? *std::move(bytes) : std::string();
}

std::vector<PagePicture> pictures_beside(const std::filesystem::path& folder, const PageJson& report) {
  std::vector<PagePicture> pictures;
  const auto add = [&](const std::string& kind, const std::string& named) {
    const std::string bytes = bytes_beside(folder, named, kMostPictureBytes);
    const auto raw = std::as_bytes(std::span(bytes));
    if (!bytes.empty()) pictures.push_back({kind, {raw.begin(), raw.end()}});
  };
  for (const char* kind : {"preview", "error", "coverage"}) add(kind, text_at(report, std::string("/files/") + kind));
  const PageJson pairs = report.at("/alignment/pairs");
  for (std::size_t i = 0; pairs.is_array() && i < std::min(pairs.size(), kMostPairs); ++i) {
    const auto scan = [&](const char* pointer) { return grouped_digits(number_at(pairs[i], pointer).value_or(0)); };
    add("pair " + scan("/from") + " " + scan("/to"), text_at(pairs[i], "/picture"));
  }
  return pictures;
}

std::string page_of(const PageJson& report, std::string_view trajectory, const PageUris& pictures) {
  std::string html(kHead);
  html += page_head(report) + pictures_section(report, pictures) + path_section(report, trajectory) +
          tracking_section(report) + turntable_section(report) + alignment_section(report, pictures) +
          holes_section(report) + finish_section(report) + topology_section(report) + losses_section(report) +
          times_section(report) + files_section(report) + config_section(report);
  return html + "<footer>ScanKnit " + escaped(text_at(report, "/version")) +
         "; the same in numbers: report.json</footer>\n</body>\n</html>\n";
}

}  // namespace

Result<std::string> report_page(std::string_view report_json, std::string_view trajectory,
                                std::span<const PagePicture> pictures) {
  const auto report = parse(report_json);
  if (!report) return report.error();
  return page_of(PageJson(&*report), trajectory, uris_of(pictures));
}

Result<void> check_report(std::string_view report_json) {
  const auto report = parse(report_json);
  if (!report) return report.error();
  const auto wrong = [](const char* key, const char* type) {
    return Error{ErrorCode::kInput, fmt::format("is no report of scanknit: `{}` is no {}", key, type)};
  };
  for (const char* key : {"version", "status", "exit_code"}) {
    if (!report->contains(key)) return Error{ErrorCode::kInput, fmt::format("is no report of scanknit: no `{}`", key)};
  }
  if (!(*report)["exit_code"].is_number_integer()) return wrong("exit_code", "whole number");
  for (const char* key : {"version", "status", "input"}) {
    if (report->contains(key) && !(*report)[key].is_string()) return wrong(key, "text");
  }
  const auto is_missing = [&](const char* key) { return !report->contains(key) || (*report)[key].is_null(); };
  for (const char* key : {"total_ms", "peak_rss_mib"}) {
    if (!is_missing(key) && !(*report)[key].is_number()) return wrong(key, "number");
  }
  if (!is_missing("warnings") && !(*report)["warnings"].is_array()) return wrong("warnings", "list");
  for (const char* key : {"frames", "losses", "tracking", "turntable", "alignment", "stages", "volume", "mesh", "holes",
                          "fit", "extract", "finish", "texture", "files", "config"}) {
    if (!is_missing(key) && !(*report)[key].is_object()) return wrong(key, "object");
  }
  return {};
}

Result<void> write_report_page(std::string_view report_json, const std::filesystem::path& page,
                               const std::filesystem::path& trajectory) {
  const auto report = parse(report_json);
  if (!report) return report.error();
  const PageJson root(&*report);
  const std::filesystem::path folder = page.parent_path();
  const std::filesystem::path poses_file =
      trajectory.empty() ? folder / std::filesystem::path(text_at(root, "/files/trajectory")).filename() : trajectory;
  const auto poses = read_text_file(poses_file, Limits{}.max_text_bytes);
  const std::vector<PagePicture> pictures = pictures_beside(folder, root);
  return write_file_atomically(page, page_of(root, poses ? *poses : std::string(), uris_of(pictures)));
}

}  // namespace scanknit
