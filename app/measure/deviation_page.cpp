#include "app/measure/deviation_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <vector>

#include "core/picture/png_codec.h"
#include "export/report/page_text.h"

namespace scanknit {
namespace {

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<title>Deviation</title>
<style>
:root { color-scheme: light dark; }
body { margin: 0 auto; max-width: 60rem; padding: 1rem; font: 16px/1.5 system-ui, sans-serif; overflow-wrap: anywhere; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .25rem .6rem; border-bottom: 1px solid #8888; }
td + td { white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
.bad { color: #b3261e; font-weight: 600; }
.good { color: #1d7a46; font-weight: 600; }
img, svg { max-width: 100%; height: auto; }
</style>
</head>
<body>
)";

std::string millimetres(double metres) {
  return fmt::format("{:.4f}", metres * 1000);
}

std::string stats_row(const std::string& name, const DeviationStats& stats, const std::string& more) {
  return fmt::format("<tr><td>{}</td><td>{:+.4f}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>{}</tr>\n", name,
                     stats.mean_m * 1000, millimetres(stats.rms_m), millimetres(stats.absolute_percentiles_m[0]),
                     millimetres(stats.absolute_percentiles_m[2]), millimetres(stats.max_absolute_m), more);
}

std::string table(const std::string& first, const std::string& more, const std::string& rows) {
  return fmt::format(
      "<div class=\"scroll\"><table>\n<tr><th>{}</th><th>mean, mm</th><th>rms</th><th>|d| median</th>"
      "<th>|d| 95 %</th><th>|d| most</th>{}</tr>\n{}</table></div>\n",
      first, more, rows);
}

std::string verdict(const Comparison& comparison) {
  const auto& beyond = comparison.compared.beyond;
  if (!beyond) return "";
  const bool is_kept = *comparison.is_within_tolerance();
  return fmt::format(
      "<p class=\"{}\">Tolerance of {}: {}. Beyond it are {:.3g} % of the vertices, {:.3g} % of the area and {:.3g} % "
      "of "
      "the reference's area.</p>\n",
      is_kept ? "good" : "bad", in_millimetres(*comparison.tolerance_m), is_kept ? "kept" : "not kept",
      beyond->vertices * 100, beyond->area * 100, beyond->reference_area * 100);
}

/// The parts of the box, the one that deviates most first.
std::string regions_table(std::vector<DeviationRegion> regions) {
  std::stable_sort(regions.begin(), regions.end(),
                   [](const DeviationRegion& a, const DeviationRegion& b) { return a.area.rms_m > b.area.rms_m; });
  std::string rows;
  bool has_tolerance = false;
  for (const DeviationRegion& region : regions) {
    std::string more = fmt::format("<td>{:.1f} %</td>", region.area_share * 100);
    has_tolerance = region.beyond.has_value();
    if (region.beyond) more += fmt::format("<td>{:.3g} %</td>", *region.beyond * 100);
    rows += stats_row(extent_words(region.box_m), region.area, more);
  }
  return table("part", has_tolerance ? "<th>of the area</th><th>beyond</th>" : "<th>of the area</th>", rows);
}

}  // namespace

Result<std::string> deviation_page(const Comparison& comparison, const ColourImage& picture,
                                   const std::string& histogram) {
  const auto png = encode_png(picture, PngEffort::kSmall);
  if (!png) return Error{ErrorCode::kOutput, png.error().message, "report.html"};
  const MeshDeviation& deviation = comparison.compared.deviation;
  std::string page = kHead;
  page += fmt::format(
      "<h1>Deviation of {}</h1>\n<p>From {}; {} and {} triangles. Positive is outside of the reference.</p>\n",
      escaped(comparison.mesh.path.filename().string()), escaped(comparison.reference.path.filename().string()),
      grouped_digits(static_cast<double>(comparison.mesh.triangles)),
      grouped_digits(static_cast<double>(comparison.reference.triangles)));
  page += verdict(comparison);
  page += "<img alt=\"The mesh in the colours of its deviations, from two sides\" src=\"data:image/png;base64," +
          base64(std::as_bytes(std::span(*png))) + "\">\n" + histogram;
  page += table("", "",
                stats_row("vertices", deviation.vertices, "") + stats_row("area", deviation.area, "") +
                    stats_row("area of the reference, from the mesh", deviation.reference_area, ""));
  page += "<h2>By parts of the reference's bounding box</h2>\n" + regions_table(deviation.regions);
  return page + "</body>\n</html>\n";
}

}  // namespace scanknit
