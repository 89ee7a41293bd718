#include "export/report/page_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "export/picture/surface_fit.h"
#include "export/report/page_charts.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostRows = 100;  // of a table; report.json has them all
constexpr std::size_t kMostPairs = 12;  // of pictures of pairs

using Rows = std::vector<std::vector<std::string>>;

std::string section(const std::string& title, const std::string& body) {
  return body.empty() ? "" : "<section>\n<h2>" + title + "</h2>\n" + body + "</section>\n";
}

std::string paragraph(const std::string& html) {
  return "<p>" + html + "</p>\n";
}

std::string count_at(const PageJson& json, const std::string& pointer) {
  const auto count = number_at(json, pointer);
  return count ? grouped_digits(*count) : "not known";
}

std::string length_at(const PageJson& json, const std::string& pointer) {
  const auto metres = number_at(json, pointer);
  return metres ? length_words(*metres) : "not known";
}

std::string yes_or_no(const PageJson& json, const std::string& pointer) {
  const PageJson value = json.at(pointer);
  if (!value.is_boolean()) return "not known";
  return value.is_true() ? "yes" : "<strong>no</strong>";
}

/// "198 x 249 x 124 mm"; nothing without bounds.
std::optional<std::string> size_words(const PageJson& bounds_m) {
  if (!bounds_m.is_array() || bounds_m.size() != 2) return std::nullopt;
  std::string words;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double ends[2] = {};
    for (std::size_t i = 0; i < 2; ++i) {
      if (!bounds_m[i].is_array() || bounds_m[i].size() != 3 || !bounds_m[i][axis].is_number()) return std::nullopt;
      ends[i] = bounds_m[i][axis].as_number();
    }
    words += fmt::format("{}{:.1f}", axis == 0 ? "" : " × ", 1000 * (ends[1] - ends[0]));
  }
  return words + " mm";
}

std::string list_of(const PageJson& texts) {
  if (!texts.is_array() || texts.empty()) return "";
  std::string html = "<ul>\n";
  for (std::size_t i = 0; i < std::min(texts.size(), kMostRows); ++i) {
    if (texts[i].is_string()) html += "<li>" + escaped(texts[i].as_text()) + "</li>\n";
  }
  return html + "</ul>\n";
}

/// A row for each member, in their order.
std::string table_of(const std::string& name, const PageJson& object, bool with_zeros) {
  if (!object.is_object()) return "";
  Rows rows;
  for (const auto& [key, value] : object.items()) {
    if (!value.is_number() || (!with_zeros && value.as_number() == 0)) continue;
    rows.push_back({escaped(key), grouped_digits(value.as_number())});
  }
  return rows.empty() ? "" : table({name, "count"}, rows);
}

std::string picture(const std::string& uri, const std::string& alt, const std::string& caption) {
  return "<figure><img src=\"" + uri + "\" alt=\"" + escaped(alt) + "\"><figcaption>" + caption +
         "</figcaption></figure>\n";
}

template <std::size_t N>
std::string ramp(const Rgb8 (&colours)[N], const std::string& from, const std::string& to) {
  std::string stops;
  for (const Rgb8 colour : colours) stops += "," + css_colour(colour);
  return "<span class=\"ramp\">" + from + "<i style=\"background:linear-gradient(90deg" + stops + ")\"></i>" + to +
         "</span> <i style=\"background:" + css_colour(kUnseenColour) + "\"></i>not seen";
}

std::string fact(const std::string& name, const std::string& value) {
  return "<div><dt>" + name + "</dt><dd>" + value + "</dd></div>\n";
}

std::string millimetres_at(const PageJson& json, const std::string& pointer) {
  const auto value = number_at(json, pointer);
  return value ? fmt::format("{:.3g} mm", *value) : "?";
}

std::string share_at(const PageJson& json, const std::string& pointer) {
  const auto value = number_at(json, pointer);
  return value ? fmt::format("{:.1f} %", 100 * *value) : "?";
}

}  // namespace

std::string page_head(const PageJson& report) {
  const bool is_good = number_at(report, "/exit_code").value_or(1) == 0;
  std::string html =
      "<header>\n<h1>Scan report</h1>\n<p class=\"input\">" + escaped(text_at(report, "/input")) + "</p>\n";
  html += fmt::format("<p class=\"status {}\">{}</p>\n", is_good ? "good" : "bad", escaped(text_at(report, "/status")));
  html += list_of(report.at("/warnings")) + "<dl>\n";
  if (const auto size = size_words(report.at("/mesh/bounds_m"))) html += fact("Size", *size);
  if (number_at(report, "/mesh/triangles")) html += fact("Triangles", count_at(report, "/mesh/triangles"));
  if (number_at(report, "/frames/read").value_or(0) > 0) {
    html += fact("Frames fused", count_at(report, "/frames/fused") + " of " + count_at(report, "/frames/read"));
  }
  if (number_at(report, "/volume/voxel_size_m").value_or(0) > 0) {
    html += fact("Voxel", length_at(report, "/volume/voxel_size_m"));
  }
  if (const auto median = number_at(report, "/fit/median_m")) {
    html += fact("Error against depth frames", "median " + length_words(*median));
  }
  if (number_at(report, "/texture/bytes").value_or(0) > 0) {
    html += fact("Texture", count_at(report, "/texture/width") + " × " + count_at(report, "/texture/height") +
                                " texels, " + share_at(report, "/texture/seen_share") + " of them seen");
  }
  html += fact("Time", time_words(number_at(report, "/total_ms").value_or(0)));
  return html + "</dl>\n</header>\n";
}

std::string pictures_section(const PageJson& report, const PageUris& pictures) {
  const auto uri_of = [&](const char* kind) {
    const auto found = pictures.find(kind);
    return found == pictures.end() ? std::string() : found->second;
  };
  std::string html;
  const bool is_streamed = report.at("/mesh").is_object() && report.at("/mesh/components").is_null();
  if (const auto uri = uri_of("preview"); !uri.empty()) {
    html +=
        picture(uri, "Four views of the mesh",
                is_streamed ? "The mesh from three sides. It was never in memory as a whole, and is drawn coarsely: "
                              "vertices that lie close together as one."
                            : "The mesh from three sides, and in clay.");
  }
  const std::string frames = count_at(report, "/fit/frames");
  if (const auto uri = uri_of("error"); !uri.empty()) {
    html += picture(uri, "Heat map of the error",
                    "Error against " + frames + " depth frames, as they were fused: median " +
                        length_at(report, "/fit/median_m") + ", 95 % below " + length_at(report, "/fit/p95_m") +
                        ".<br>" + ramp(kErrorRamp, "0", length_at(report, "/fit/error_map_end_m")));
  }
  if (const auto uri = uri_of("coverage"); !uri.empty()) {
    html += picture(uri, "Map of coverage",
                    "Coverage: how many of " + frames + " depth frames saw each place. " +
                        percent(number_at(report, "/fit/seen_share").value_or(0)) + " of the vertices were seen.<br>" +
                        ramp(kCoverageRamp, "1", count_at(report, "/fit/coverage_map_end")));
  }
  if (html.empty() && report.at("/mesh").is_object()) {
    html += paragraph("There are no pictures: <code>export.preview</code> is off, or they have been removed.");
  }
  return section("Pictures", html);
}

std::string path_section(const PageJson& report, std::string_view trajectory) {
  if (report.at("/alignment").is_object()) return "";  // poses of scans, which no camera walked along
  return section("Camera path",
                 camera_path(trajectory, report.at("/finish/T_mesh_world"), report.at("/mesh/bounds_m")));
}

std::string holes_section(const PageJson& report) {
  const PageJson holes = report.at("/holes");
  if (!holes.is_object()) return "";
  if (number_at(holes, "/count").value_or(0) == 0) return section("Holes", paragraph("None: the surface is closed."));
  std::string html = paragraph(count_at(holes, "/count") + " open rims, " + length_at(holes, "/total_length_m") +
                               " long together. The outer border of an open surface is one of them.");
  Rows rows;
  const PageJson longest = holes.at("/longest_m");
  for (std::size_t i = 0; longest.is_array() && i < std::min<std::size_t>(longest.size(), 20); ++i) {
    if (longest[i].is_number()) rows.push_back({std::to_string(i + 1), length_words(longest[i].as_number())});
  }
  return section("Holes", html + table({"the longest", "length of the rim"}, rows));
}

std::string finish_section(const PageJson& report) {
  const PageJson finish = report.at("/finish");
  if (!finish.is_structured() || finish.empty()) return "";
  Rows rows;
  const PageJson steps = finish.at("/steps");
  for (std::size_t i = 0; steps.is_array() && i < std::min(steps.size(), kMostRows); ++i) {
    const std::string refused = text_at(steps[i], "/refused");
    std::string done = refused.empty() ? "" : "not done: " + escaped(refused);
    const PageJson figures = steps[i].at("/figures");
    const std::size_t most = figures.empty() ? 0 : kMostRows;
    for (const auto& [name, value] : flattened(figures, most)) {
      const auto figure = number_at(figures, "/" + name);
      done += (done.empty() ? "" : "<br>") + escaped(figure ? figure_words(name, *figure) : name + " " + value);
    }
    rows.push_back({escaped(text_at(steps[i], "/name")), done});
  }
  return section("Finishing", table({"step", "what it changed"}, rows));
}

std::string tracking_section(const PageJson& report) {
  const PageJson tracking = report.at("/tracking");
  if (!tracking.is_object()) {
    const bool has_frames = number_at(report, "/frames/fused").value_or(0) > 0;
    return has_frames ? section("Tracking", paragraph("Nothing was tracked: the poses are the recording's own, or of "
                                                      "scans that were brought together."))
                      : "";
  }
  std::string html = table_of("state", tracking.at("/states"), true) + tracking_chart(tracking.at("/frames"));
  std::map<std::string, std::size_t> reasons;
  const PageJson frames = tracking.at("/frames");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const PageJson frame = frames[i];
    const std::string reason = text_at(frame, "/reason");
    if (!reason.empty()) ++reasons[text_at(frame, "/state") + ": " + reason];
  }
  Rows rows;
  for (const auto& [reason, count] : reasons) rows.push_back({escaped(reason), std::to_string(count)});
  if (rows.size() > kMostRows) rows.resize(kMostRows);
  if (!rows.empty()) html += table({"reason", "frames"}, rows);
  if (tracking.at("/loops").is_object()) {
    html += paragraph(tracking.at("/loops/is_corrected").is_true()
                          ? "The walk came back " + length_at(tracking, "/loops/drift_m") +
                                " beside where it had been: the loop was closed."
                          : "No drift had to be corrected where the walk came back, or it did not.");
  }
  return section("Tracking", html);
}

std::string turntable_section(const PageJson& report) {
  const PageJson turntable = report.at("/turntable");
  if (!turntable.is_object()) return "";
  const std::string reason = text_at(turntable, "/reason");
  if (!reason.empty()) return section("Turntable", paragraph("Left as tracked: " + escaped(reason) + "."));
  Rows rows = {{"turns", fmt::format("{:.2f}", number_at(turntable, "/turns").value_or(0))},
               {"closed", yes_or_no(turntable, "/is_closed")},
               {"left between frames", length_at(turntable, "/rms_m") +
                                           fmt::format(", {:.2f}°", number_at(turntable, "/rms_degrees").value_or(0))},
               {"key frames", count_at(turntable, "/key_frames")}};
  return section("Turntable", table({}, rows));
}

std::string alignment_section(const PageJson& report, const PageUris& pictures) {
  const PageJson pairs = report.at("/alignment/pairs");
  if (!pairs.is_array()) return "";
  Rows rows;
  for (std::size_t i = 0; i < std::min(pairs.size(), kMostRows); ++i) {
    const PageJson pair = pairs[i];
    const std::string reason = text_at(pair, "/reason");
    rows.push_back({count_at(pair, "/from") + " and " + count_at(pair, "/to"), millimetres_at(pair, "/residual_mm"),
                    share_at(pair, "/overlap"), share_at(pair, "/contradicted"), share_at(pair, "/missing"),
                    escaped(text_at(pair, "/verdict")) + (reason.empty() ? "" : ": " + escaped(reason))});
  }
  std::string html = table({"scans", "residual", "overlap", "in the way", "missing", "verdict"}, rows);
  std::size_t shown = 0;
  for (const auto& [kind, uri] : pictures) {
    if (!kind.starts_with("pair ") || uri.empty() || shown == kMostPairs) continue;
    ++shown;
    html += picture(uri, kind, escaped(kind) + ": the first scan is orange, the second blue");
  }
  return section("Scans brought together", html);
}

std::string losses_section(const PageJson& report) {
  const PageJson frames = report.at("/frames");
  if (number_at(frames, "/read").value_or(0) == 0 && !report.at("/losses").is_object()) return "";
  std::string html = table({}, {{"frames read", count_at(frames, "/read")},
                                {"fused", count_at(frames, "/fused")},
                                {"dropped", count_at(frames, "/dropped")},
                                {"pose not found", count_at(frames, "/lost")}});
  html += table_of("dropped because", frames.at("/dropped_by_reason"), false);
  const PageJson messages = frames.at("/drop_messages");
  if (messages.is_array() && !messages.empty()) {
    html += "<details><summary>Messages</summary>\n" + list_of(messages) + "</details>\n";
  }
  if (report.at("/losses").is_object()) {
    const std::string lost = table_of("pictures of the scanner lost in", report.at("/losses"), true);
    html += lost;
  }
  return section("Losses", html);
}

std::string topology_section(const PageJson& report) {
  const PageJson mesh = report.at("/mesh");
  if (!mesh.is_object()) return section("Topology", paragraph("There is no mesh."));
  if (mesh.at("/components").is_null()) {
    return section("Topology", paragraph("The mesh was streamed: " + count_at(mesh, "/vertices") + " vertices, " +
                                         count_at(mesh, "/triangles") + " triangles, not checked."));
  }
  const Rows rows = {{"closed", yes_or_no(mesh, "/is_closed")},
                     {"manifold", yes_or_no(mesh, "/is_manifold")},
                     {"well formed", yes_or_no(mesh, "/is_well_formed")},
                     {"vertices", count_at(mesh, "/vertices")},
                     {"triangles", count_at(mesh, "/triangles")},
                     {"pieces", count_at(mesh, "/components")},
                     {"Euler characteristic", count_at(mesh, "/euler")},
                     {"boundary edges", count_at(mesh, "/boundary_edges")},
                     {"non-manifold edges", count_at(mesh, "/non_manifold_edges")},
                     {"non-manifold vertices", count_at(mesh, "/non_manifold_vertices")},
                     {"misoriented edges", count_at(mesh, "/misoriented_edges")},
                     {"degenerate triangles", count_at(mesh, "/degenerate_triangles")},
                     {"duplicate triangles", count_at(mesh, "/duplicate_triangles")}};
  return section("Topology", table({}, rows));
}

std::string times_section(const PageJson& report) {
  const std::string bars = stage_bars(report.at("/stages"));
  const auto memory_mib = number_at(report, "/peak_rss_mib");
  const std::string memory = memory_mib ? fmt::format(", at most {:.0f} MiB of memory", *memory_mib) : "";
  return section("Time",
                 paragraph(time_words(number_at(report, "/total_ms").value_or(0)) + " in all" + memory + ".") + bars);
}

std::string files_section(const PageJson& report) {
  const PageJson files = report.at("/files");
  Rows rows;
  if (files.is_object()) {
    for (const auto& [kind, path] : files.items()) {
      if (path.is_string() && rows.size() < kMostRows) rows.push_back({escaped(kind), escaped(path.as_text())});
    }
  }
  return rows.empty() ? "" : section("Files", table({}, rows));
}

std::string config_section(const PageJson& report) {
  const PageJson config = report.at("/config");
  if (!config.is_object() || config.empty()) return "";
  constexpr std::size_t kMostKeys = 400;
  Rows rows;
  for (const auto& [name, value] : flattened(config, kMostKeys)) rows.push_back({escaped(name), escaped(value)});
  return section("Configuration", "<details><summary>" + std::to_string(rows.size()) + " values</summary>\n" +
                                      table({}, rows) + "</details>\n");
}

}  // namespace scanknit
