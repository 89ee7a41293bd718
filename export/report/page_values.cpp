#include "export/report/page_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <kainjow/mustache.hpp>
#include <span>
#include <utility>
#include <vector>

#include "core/check.h"
#include "export/picture/surface_fit.h"
#include "export/report/page_charts.h"
#include "export/report/page_template.h"
#include "export/report/page_text.h"

namespace scanknit {
namespace {

using kainjow::mustache::data;
using kainjow::mustache::list;
using kainjow::mustache::object;

constexpr std::size_t kMostRows = 100;  // of a table; report.json has them all

/// In the template, `{{#name}}` ... `{{/name}}` is left out.
const bool kLeftOut = false;

// One value as the page writes it.

std::string count_at(const ReportJson& json, std::string_view pointer) {
  const auto count = number_at(json, pointer);
  return count ? grouped_digits(*count) : "not known";
}

std::string length_at(const ReportJson& json, std::string_view pointer) {
  const auto metres = number_at(json, pointer);
  return metres ? length_words(*metres) : "not known";
}

std::string area_at(const ReportJson& json, std::string_view pointer) {
  const auto metres2 = number_at(json, pointer);
  return metres2 ? fmt::format("{:.3g} cm2", 1e4 * *metres2) : "not known";
}

std::string millimetres_at(const ReportJson& json, std::string_view pointer) {
  const auto value = number_at(json, pointer);
  return value ? fmt::format("{:.3g} mm", *value) : "?";
}

std::string share_at(const ReportJson& json, std::string_view pointer) {
  const auto value = number_at(json, pointer);
  return value ? fmt::format("{:.1f} %", 100 * *value) : "?";
}

bool is_true_at(const ReportJson& json, std::string_view pointer) {
  return value_at(json, pointer) == true;
}

/// The counts of `json` by their names.
object counts_at(const ReportJson& json, std::initializer_list<const char*> names) {
  object counts;
  for (const std::string name : names) counts[name] = count_at(json, "/" + name);
  return counts;
}

/// HTML: what is bad stands out.
std::string yes_or_no(const ReportJson& json, std::string_view pointer) {
  if (!value_at(json, pointer).is_boolean()) return "not known";
  return is_true_at(json, pointer) ? "yes" : "<strong>no</strong>";
}

std::string two_decimals(double number) {
  return fmt::format("{:.2f}", number);
}

/// Three numbers; nothing when it is something else.
std::optional<Eigen::Vector3d> vector_of(const ReportJson& numbers) {
  if (!numbers.is_array() || numbers.size() != 3) return std::nullopt;
  Eigen::Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = number_of(numbers[i]);
    if (!number) return std::nullopt;
    vector[static_cast<Eigen::Index>(i)] = *number;
  }
  return vector;
}

/// The box of the report's or a class' mesh; an empty one when it is not known.
Eigen::AlignedBox3d mesh_box(const ReportJson& report) {
  Eigen::AlignedBox3d box;
  const ReportJson& bounds_m = list_at(report, "/mesh/bounds_m");
  if (bounds_m.size() != 2) return box;
  for (const ReportJson& corner : bounds_m) {
    const auto p = vector_of(corner);
    if (!p) return {};
    box.extend(*p);
  }
  return box;
}

/// The motion that finishing put the mesh by, four rows of four numbers; the identity when there is none.
Eigen::Affine3d mesh_from_world(const ReportJson& report) {
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  const ReportJson& rows = list_at(report, "/finish/T_mesh_world");
  if (rows.size() != 4) return T;
  for (std::size_t row = 0; row < 3; ++row) {
    if (!rows[row].is_array() || rows[row].size() != 4) return Eigen::Affine3d::Identity();
    for (std::size_t column = 0; column < 4; ++column) {
      const auto number = number_of(rows[row][column]);
      if (!number) return Eigen::Affine3d::Identity();
      T(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = *number;
    }
  }
  return T;
}

// Lists and tables.

data texts_of(const ReportJson& texts) {
  if (texts.empty()) return kLeftOut;
  list shown;
  for (std::size_t i = 0; i < std::min(texts.size(), kMostRows); ++i) {
    if (texts[i].is_string()) shown.emplace_back(texts[i].get<std::string>());
  }
  return object{{"texts", shown}};
}

data table_of(const list& rows) {
  return rows.empty() ? data(kLeftOut) : object{{"rows", rows}};
}

enum class Zeros { kShown, kSkipped };

data counts_of(const ReportJson& counts, Zeros zeros) {
  list rows;
  for (const auto& [name, value] : counts.items()) {
    const auto count = number_of(value);
    if (!count || (zeros == Zeros::kSkipped && *count == 0)) continue;
    rows.push_back(object{{"name", name}, {"count", grouped_digits(*count)}});
  }
  return table_of(rows);
}

// The parts of the page, in its order.

void add_head(const ReportJson& report, object& page) {
  page["input"] = text_at(report, "/input");
  page["status"] = text_at(report, "/status");
  page["verdict"] = number_at(report, "/exit_code").value_or(1) == 0 ? "good" : "bad";
  page["warnings"] = texts_of(list_at(report, "/warnings"));
  page["version"] = text_at(report, "/version");
  page["total_time"] = time_words(number_at(report, "/total_ms").value_or(0));
}

std::string size_words(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return "not known";
  const Eigen::Vector3d mm = 1000 * box.sizes();
  return fmt::format("{:.1f} × {:.1f} × {:.1f} mm", mm.x(), mm.y(), mm.z());
}

void add_facts(const ReportJson& report, object& page) {
  if (const Eigen::AlignedBox3d box = mesh_box(report); !box.isEmpty()) page["size"] = size_words(box);
  if (number_at(report, "/mesh/triangles")) page["triangles"] = count_at(report, "/mesh/triangles");
  if (number_at(report, "/frames/read").value_or(0) > 0) {
    page["frames"] = counts_at(value_at(report, "/frames"), {"fused", "read"});
  }
  if (number_at(report, "/volume/voxel_size_m").value_or(0) > 0) {
    page["voxel"] = length_at(report, "/volume/voxel_size_m");
  }
  if (number_at(report, "/fit/median_m")) page["median_error"] = length_at(report, "/fit/median_m");
  if (number_at(report, "/texture/bytes").value_or(0) > 0) {
    object texture = counts_at(value_at(report, "/texture"), {"width", "height"});
    texture["seen_share"] = share_at(report, "/texture/seen_share");
    page["texture"] = texture;
  }
}

std::string gradient_stops(std::span<const Rgb8> colours) {
  std::string stops;
  for (const Rgb8 colour : colours) stops += "," + css_colour(colour);
  return stops;
}

data pictures_of(const ReportJson& report, const PageUris& pictures) {
  const auto uri_of = [&](const char* kind) {
    const auto found = pictures.find(kind);
    return found == pictures.end() ? std::string() : found->second;
  };
  object shown;
  const ReportJson& mesh = value_at(report, "/mesh");
  if (const auto uri = uri_of("preview"); !uri.empty()) {
    const bool is_streamed = mesh.is_object() && value_at(mesh, "/components").is_null();
    shown["preview"] = object{{"uri", uri}, {"is_streamed", is_streamed}};
  }
  const std::string frames = count_at(report, "/fit/frames"), unseen = css_colour(kUnseenColour);
  if (const auto uri = uri_of("error"); !uri.empty()) {
    shown["error"] = object{{"uri", uri},
                            {"frames", frames},
                            {"median", length_at(report, "/fit/median_m")},
                            {"p95", length_at(report, "/fit/p95_m")},
                            {"stops", gradient_stops(kErrorRamp)},
                            {"end", length_at(report, "/fit/error_map_end_m")},
                            {"unseen", unseen}};
  }
  if (const auto uri = uri_of("coverage"); !uri.empty()) {
    shown["coverage"] = object{{"uri", uri},
                               {"frames", frames},
                               {"seen_share", percent(number_at(report, "/fit/seen_share").value_or(0))},
                               {"stops", gradient_stops(kCoverageRamp)},
                               {"end", count_at(report, "/fit/coverage_map_end")},
                               {"unseen", unseen}};
  }
  if (shown.empty() && mesh.is_object()) shown["are_missing"] = true;
  return shown.empty() ? data(kLeftOut) : data(shown);
}

object side_of(const PathDrawing& drawing, const char* right, const char* down) {
  object side = {{"points", drawing.points},
                 {"first_x", two_decimals(drawing.first.x())},
                 {"first_y", two_decimals(drawing.first.y())},
                 {"last_x", two_decimals(drawing.last.x())},
                 {"last_y", two_decimals(drawing.last.y())},
                 {"right", right},
                 {"down", down},
                 {"side", length_words(drawing.side_m)}};
  if (drawing.mesh) {
    side["box"] = object{{"x", two_decimals(drawing.mesh->x)},
                         {"y", two_decimals(drawing.mesh->y)},
                         {"width", two_decimals(drawing.mesh->width)},
                         {"height", two_decimals(drawing.mesh->height)}};
  }
  return side;
}

data camera_path_of(const ReportJson& report, std::string_view trajectory) {
  if (value_at(report, "/alignment").is_object()) return kLeftOut;  // poses of scans, which no camera walked along
  std::vector<Eigen::Vector3d> positions = camera_positions(trajectory);
  if (positions.size() < 2) return kLeftOut;
  const Eigen::Affine3d T_mesh_world = mesh_from_world(report);
  for (Eigen::Vector3d& position : positions) position = T_mesh_world * position;
  const Eigen::AlignedBox3d mesh = mesh_box(report);
  return object{{"sides", list{side_of(draw_path(positions, mesh, 0, 2), "x", "z"),
                               side_of(draw_path(positions, mesh, 0, 1), "x", "y")}}};
}

data chart_of(const ReportJson& frames) {
  if (frames.empty()) return kLeftOut;
  std::vector<TrackedFrameShares> shares;
  for (const ReportJson& frame : frames) {
    shares.push_back({number_at(frame, "/overlap").value_or(0), number_at(frame, "/inlier_share").value_or(0),
                      text_at(frame, "/state")});
  }
  const TrackingChart chart = tracking_chart(shares);
  list columns;
  for (const std::string_view state : chart.states) {
    columns.push_back(object{{"state", std::string(state)}, {"x", std::to_string(columns.size())}});
  }
  const auto number_of_frame = [&](std::size_t i) {
    return grouped_digits(number_at(frames[i], "/frame").value_or(static_cast<double>(i)));
  };
  return object{{"width", std::to_string(columns.size())},
                {"columns", columns},
                {"overlap", chart.overlap},
                {"inliers", chart.inliers},
                {"first", number_of_frame(0)},
                {"last", number_of_frame(frames.size() - 1)}};
}

/// Why frames were not tracked well, and how many for each reason.
data reasons_of(const ReportJson& frames) {
  std::map<std::string, std::size_t> count_of;
  for (const ReportJson& frame : frames) {
    const std::string reason = text_at(frame, "/reason");
    if (!reason.empty()) ++count_of[text_at(frame, "/state") + ": " + reason];
  }
  list rows;
  for (const auto& [reason, count] : count_of) {
    if (rows.size() < kMostRows) rows.push_back(object{{"name", reason}, {"count", std::to_string(count)}});
  }
  return table_of(rows);
}

data tracking_of(const ReportJson& report) {
  const ReportJson& tracking = value_at(report, "/tracking");
  if (!tracking.is_object()) {
    const bool has_frames = number_at(report, "/frames/fused").value_or(0) > 0;
    return has_frames ? data(object{{"are_poses_given", true}}) : data(kLeftOut);
  }
  const ReportJson& frames = list_at(tracking, "/frames");
  object shown = {{"states", counts_of(object_at(tracking, "/states"), Zeros::kShown)},
                  {"chart", chart_of(frames)},
                  {"reasons", reasons_of(frames)},
                  {"loops", kLeftOut}};
  if (value_at(tracking, "/loops").is_object()) {
    shown["loops"] = object{{"is_corrected", is_true_at(tracking, "/loops/is_corrected")},
                            {"drift", length_at(tracking, "/loops/drift_m")}};
  }
  const bool is_empty =
      std::all_of(shown.begin(), shown.end(), [](const auto& part) { return part.second.is_false(); });
  return is_empty ? data(kLeftOut) : data(shown);
}

data turntable_of(const ReportJson& report) {
  const ReportJson& turntable = value_at(report, "/turntable");
  if (!turntable.is_object()) return kLeftOut;
  const std::string reason = text_at(turntable, "/reason");
  if (!reason.empty()) return object{{"not_refined", object{{"reason", reason}}}};
  const object refined = {{"turns", two_decimals(number_at(turntable, "/turns").value_or(0))},
                          {"is_closed", yes_or_no(turntable, "/is_closed")},
                          {"distance", length_at(turntable, "/rms_m")},
                          {"angle", two_decimals(number_at(turntable, "/rms_degrees").value_or(0)) + "°"},
                          {"key_frames", count_at(turntable, "/key_frames")}};
  return object{{"refined", refined}};
}

data silhouettes_of(const ReportJson& report) {
  const ReportJson& silhouettes = value_at(report, "/silhouettes");
  if (!silhouettes.is_object()) return kLeftOut;
  return object{{"pictures", count_at(silhouettes, "/pictures")},
                {"agreement", share_at(silhouettes, "/agreement")},
                {"worst_overlap", share_at(silhouettes, "/worst_overlap")},
                {"worst_picture", text_at(silhouettes, "/worst_picture")}};
}

data alignment_of(const ReportJson& report, const PageUris& pictures) {
  const ReportJson& pairs = value_at(report, "/alignment/pairs");
  if (!pairs.is_array()) return kLeftOut;
  list rows;
  for (std::size_t i = 0; i < std::min(pairs.size(), kMostRows); ++i) {
    const ReportJson& pair = pairs[i];
    const std::string reason = text_at(pair, "/reason");
    rows.push_back(object{{"from", count_at(pair, "/from")},
                          {"to", count_at(pair, "/to")},
                          {"residual", millimetres_at(pair, "/residual_mm")},
                          {"overlap", share_at(pair, "/overlap")},
                          {"contradicted", share_at(pair, "/contradicted")},
                          {"missing", share_at(pair, "/missing")},
                          {"verdict", text_at(pair, "/verdict")},
                          {"why", !reason.empty()},
                          {"reason", reason}});
  }
  list shown;
  for (const auto& [kind, uri] : pictures) {
    if (!kind.starts_with("pair ") || uri.empty() || shown.size() == kMostPairPictures) continue;
    shown.push_back(object{{"pair", kind}, {"uri", uri}});
  }
  return object{{"pairs", rows}, {"pair_pictures", shown}};
}

data classes_of(const ReportJson& report, const PageUris& pictures) {
  list rows, shown;
  for (const ReportJson& one : list_at(report, "/classes")) {
    if (rows.size() == kMostRows) break;
    object row = counts_at(value_at(one, "/mesh"), {"components", "triangles"});
    row["class"] = count_at(one, "/class");
    row["size"] = size_words(mesh_box(one));
    row["area"] = area_at(one, "/area_m2");
    row["is_closed"] = yes_or_no(one, "/mesh/is_closed");
    rows.push_back(row);
    const auto found = pictures.find("class " + count_at(one, "/class"));
    if (found != pictures.end()) shown.push_back(object{{"kind", found->first}, {"uri", found->second}});
  }
  return rows.empty() ? data(kLeftOut) : object{{"rows", rows}, {"class_pictures", shown}};
}

data holes_of(const ReportJson& report) {
  constexpr std::size_t kMostRims = 20;
  const ReportJson& holes = value_at(report, "/holes");
  if (!holes.is_object()) return kLeftOut;
  if (number_at(holes, "/count").value_or(0) == 0) return object{{"is_closed", true}};
  list longest;
  const ReportJson& lengths_m = list_at(holes, "/longest_m");
  for (std::size_t i = 0; i < std::min(lengths_m.size(), kMostRims); ++i) {
    const auto length_m = number_of(lengths_m[i]);
    if (length_m) longest.push_back(object{{"place", std::to_string(i + 1)}, {"length", length_words(*length_m)}});
  }
  const object rims = {
      {"rims", count_at(holes, "/count")}, {"total_length", length_at(holes, "/total_length_m")}, {"longest", longest}};
  return object{{"is_open", rims}};
}

object finishing_step(const ReportJson& step) {
  list changes;
  const auto add = [&](std::string change) {
    changes.push_back(object{{"is_first", changes.empty()}, {"change", std::move(change)}});
  };
  if (const std::string refused = text_at(step, "/refused"); !refused.empty()) add("not done: " + refused);
  const ReportJson& figures = value_at(step, "/figures");
  if (figures.is_structured() && !figures.empty()) {
    for (const auto& [name, value] : flattened(figures, kMostRows)) {
      const auto figure = number_at(figures, "/" + name);
      add(figure ? figure_words(name, *figure) : name + " " + value);
    }
  }
  return {{"name", text_at(step, "/name")}, {"changes", changes}};
}

data finishing_of(const ReportJson& report) {
  const ReportJson& finish = value_at(report, "/finish");
  if (!finish.is_structured() || finish.empty()) return kLeftOut;
  list rows;
  const ReportJson& steps = list_at(finish, "/steps");
  for (std::size_t i = 0; i < std::min(steps.size(), kMostRows); ++i) rows.push_back(finishing_step(steps[i]));
  return object{{"steps", rows}};
}

void add_topology(const ReportJson& report, object& page) {
  const ReportJson& mesh = value_at(report, "/mesh");
  if (!mesh.is_object()) {
    page["no_mesh"] = list_at(report, "/classes").empty();
    return;
  }
  object counts =
      counts_at(mesh, {"vertices", "triangles", "components", "euler", "boundary_edges", "non_manifold_edges",
                       "non_manifold_vertices", "misoriented_edges", "degenerate_triangles", "duplicate_triangles"});
  for (const std::string key : {"is_closed", "is_manifold", "is_well_formed"}) counts[key] = yes_or_no(mesh, "/" + key);
  if (value_at(report, "/doubled").is_object()) {
    counts["doubled"] = object{{"share", share_at(report, "/doubled/share")}};
  }
  page[value_at(mesh, "/components").is_null() ? "streamed_mesh" : "checked_mesh"] = counts;
}

data losses_of(const ReportJson& report) {
  const ReportJson& frames = value_at(report, "/frames");
  if (number_at(frames, "/read").value_or(0) == 0 && !value_at(report, "/losses").is_object()) return kLeftOut;
  object shown = counts_at(frames, {"read", "fused", "dropped", "lost"});
  shown["dropped_because"] = counts_of(object_at(frames, "/dropped_by_reason"), Zeros::kSkipped);
  shown["messages"] = texts_of(list_at(frames, "/drop_messages"));
  shown["lost_in"] = counts_of(object_at(report, "/losses"), Zeros::kShown);
  return shown;
}

/// Empty for reports that were written before stages had their memory.
std::string memory_words(std::optional<double> mib) {
  return mib ? fmt::format("{:.0f} MiB", *mib) : "";
}

/// A row for each stage that took time, longest first.
data stages_of(const ReportJson& report) {
  std::vector<std::pair<double, object>> stages;
  double longest_ms = 0;
  for (const auto& [name, times] : object_at(report, "/stages").items()) {
    const double total_ms = number_at(times, "/total_ms").value_or(0);
    if (total_ms <= 0) continue;
    longest_ms = std::max(longest_ms, total_ms);
    stages.emplace_back(total_ms, object{{"name", name},
                                         {"total", time_words(total_ms)},
                                         {"median", two_decimals(number_at(times, "/median_ms").value_or(0)) + " ms"},
                                         {"p95", two_decimals(number_at(times, "/p95_ms").value_or(0)) + " ms"},
                                         {"memory", memory_words(number_at(times, "/peak_rss_mib"))}});
  }
  std::stable_sort(stages.begin(), stages.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  list rows;
  for (auto& [total_ms, row] : stages) {
    row["width"] = fmt::format("{:.1f}", 100 * total_ms / longest_ms);
    rows.emplace_back(row);
  }
  return table_of(rows);
}

data files_of(const ReportJson& report) {
  list rows;
  for (const auto& [kind, path] : object_at(report, "/files").items()) {
    if (!path.is_string() || rows.size() == kMostRows) continue;
    rows.push_back(object{{"kind", kind}, {"path", path.get<std::string>()}});
  }
  return table_of(rows);
}

data configuration_of(const ReportJson& report) {
  constexpr std::size_t kMostKeys = 400;
  const ReportJson& config = object_at(report, "/config");
  if (config.empty()) return kLeftOut;
  list rows;
  for (const auto& [key, value] : flattened(config, kMostKeys)) rows.push_back(object{{"key", key}, {"value", value}});
  return object{{"count", std::to_string(rows.size())}, {"rows", rows}};
}

}  // namespace

std::string filled_page(const ReportJson& report, std::string_view trajectory, const PageUris& pictures) {
  object page;
  add_head(report, page);
  add_facts(report, page);
  page["pictures"] = pictures_of(report, pictures);
  page["camera_path"] = camera_path_of(report, trajectory);
  page["tracking"] = tracking_of(report);
  page["turntable"] = turntable_of(report);
  page["silhouettes"] = silhouettes_of(report);
  page["alignment"] = alignment_of(report, pictures);
  page["classes"] = classes_of(report, pictures);
  page["holes"] = holes_of(report);
  page["finishing"] = finishing_of(report);
  add_topology(report, page);
  page["losses"] = losses_of(report);
  if (const auto memory_mib = number_at(report, "/peak_rss_mib")) page["memory"] = memory_words(memory_mib);
  page["stages"] = stages_of(report);
  page["files"] = files_of(report);
  page["configuration"] = configuration_of(report);

  kainjow::mustache::mustache html(page_template());
  html.set_custom_escape([](const std::string& text) { return escaped(text); });
  std::string filled;  // render(page) alone fills a stream, which swallows a lack of memory and leaves half a page
  html.render(page, [&filled](const std::string& part) { filled += part; });
  SCANKNIT_CHECK(html.is_valid());
  return filled;
}

}  // namespace scanknit
