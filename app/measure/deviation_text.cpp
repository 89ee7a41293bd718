#include "app/measure/deviation_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace scanknit {
namespace {

using DeviationJson = nlohmann::ordered_json;

DeviationJson file_json(const ComparedFile& file) {
  return {{"file", file.path.string()},
          {"unit", description_of(file.unit).name},
          {"vertices", file.vertices},
          {"triangles", file.triangles}};
}

DeviationJson deviation_stats_json(const DeviationStats& stats) {
  DeviationJson percentiles, absolute;
  for (std::size_t i = 0; i < kSignedPercentiles.size(); ++i) {
    percentiles[fmt::format("p{:02}", static_cast<int>(kSignedPercentiles[i]))] = stats.percentiles_m[i];
  }
  for (std::size_t i = 0; i < kAbsolutePercentiles.size(); ++i) {
    absolute[fmt::format("p{:02}", static_cast<int>(kAbsolutePercentiles[i]))] = stats.absolute_percentiles_m[i];
  }
  return {{"count", stats.count},
          {"mean_m", stats.mean_m},
          {"standard_deviation_m", stats.deviation_m},
          {"mean_absolute_m", stats.mean_absolute_m},
          {"rms_m", stats.rms_m},
          {"min_m", stats.min_m},
          {"max_m", stats.max_m},
          {"max_absolute_m", stats.max_absolute_m},
          {"percentiles_m", percentiles},
          {"absolute_percentiles_m", absolute}};
}

const char* word_of(MeshAlignment alignment) {
  switch (alignment) {
    case MeshAlignment::kGiven: return "given";
    case MeshAlignment::kNear: return "near";
    case MeshAlignment::kShape: return "shape";
  }
  return "";
}

DeviationJson alignment_json(const Comparison& comparison) {
  DeviationJson rows = DeviationJson::array();
  const Eigen::Matrix4d matrix = comparison.placement.T_reference_mesh.matrix();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  }
  return {{"kind", word_of(comparison.alignment)},
          {"T_reference_mesh", rows},
          {"is_ambiguous", comparison.placement.is_ambiguous}};
}

DeviationJson tolerance_json(const Comparison& comparison) {
  const auto& beyond = comparison.compared.beyond;
  if (!beyond) return nullptr;
  return {{"tolerance_m", *comparison.tolerance_m},
          {"allowed_share", comparison.allowed_share},
          {"share_beyond_vertices", beyond->vertices},
          {"share_beyond_area", beyond->area},
          {"share_beyond_reference_area", beyond->reference_area},
          {"is_within", *comparison.is_within_tolerance()}};
}

/// Null without a tolerance.
DeviationJson beyond_json(const DeviationRegion& region) {
  return region.beyond ? DeviationJson(*region.beyond) : DeviationJson(nullptr);
}

DeviationJson regions_json(const std::vector<DeviationRegion>& regions) {
  DeviationJson rows = DeviationJson::array();
  for (const DeviationRegion& region : regions) {
    const Eigen::Vector3d &low = region.box_m.min(), &high = region.box_m.max();
    rows.push_back({{"min_m", {low.x(), low.y(), low.z()}},
                    {"max_m", {high.x(), high.y(), high.z()}},
                    {"area_share", region.area_share},
                    {"share_beyond_area", beyond_json(region)},
                    {"area", deviation_stats_json(region.area)}});
  }
  return rows;
}

/// The part that deviates most; "" if there is but one.
std::string worst_region_line(const std::vector<DeviationRegion>& regions) {
  if (regions.size() < 2) return "";
  const auto worst =
      std::max_element(regions.begin(), regions.end(),
                       [](const DeviationRegion& a, const DeviationRegion& b) { return a.area.rms_m < b.area.rms_m; });
  return fmt::format("Worst part  rms {:.4f} mm, |d| 95 % {:.4f}, of the {} parts of the reference's box: {}\n",
                     worst->area.rms_m * 1000, worst->area.absolute_percentiles_m[2] * 1000, regions.size(),
                     extent_words(worst->box_m));
}

std::string deviation_line(const char* name, const DeviationStats& stats) {
  constexpr double kMmPerM = 1000;
  return fmt::format(
      "{:11} mean {:+.4f} mm, deviation {:.4f}, rms {:.4f}; |d| median {:.4f}, 95 % {:.4f}, max {:.4f}; "
      "from {:+.4f} to {:+.4f}\n",
      name, stats.mean_m * kMmPerM, stats.deviation_m * kMmPerM, stats.rms_m * kMmPerM,
      stats.absolute_percentiles_m[0] * kMmPerM, stats.absolute_percentiles_m[2] * kMmPerM,
      stats.max_absolute_m * kMmPerM, stats.min_m * kMmPerM, stats.max_m * kMmPerM);
}

std::string tolerance_line(const Comparison& comparison) {
  const auto& beyond = comparison.compared.beyond;
  if (!beyond) return "";
  return fmt::format(
      "Tolerance   {}: {}; beyond it {:.3g} % of the vertices, {:.3g} % of the area ({:.3g} % of the "
      "reference's area)\n",
      in_millimetres(*comparison.tolerance_m), *comparison.is_within_tolerance() ? "kept" : "NOT kept",
      beyond->vertices * 100, beyond->area * 100, beyond->reference_area * 100);
}

}  // namespace

std::optional<bool> Comparison::is_within_tolerance() const {
  if (!compared.beyond) return std::nullopt;
  return compared.beyond->vertices <= allowed_share && compared.beyond->area <= allowed_share;
}

std::string in_millimetres(double metres) {
  return fmt::format("{:.6g} mm", metres * 1000);
}

std::string extent_words(const Eigen::AlignedBox3d& box_m) {
  const Eigen::Vector3d low = box_m.min() * 1000, high = box_m.max() * 1000;
  return fmt::format("x {:.4g} to {:.4g}, y {:.4g} to {:.4g}, z {:.4g} to {:.4g} mm", low.x(), high.x(), low.y(),
                     high.y(), low.z(), high.z());
}

std::string comparison_json(const Comparison& comparison) {
  const MeshDeviation& deviation = comparison.compared.deviation;
  DeviationJson files = DeviationJson::array();
  for (const auto& file : comparison.files) files.push_back(file.string());
  const DeviationJson json = {{"mesh", file_json(comparison.mesh)},
                              {"reference", file_json(comparison.reference)},
                              {"alignment", alignment_json(comparison)},
                              {"vertices", deviation_stats_json(deviation.vertices)},
                              {"area", deviation_stats_json(deviation.area)},
                              {"reference_area", deviation_stats_json(deviation.reference_area)},
                              {"histogram",
                               {{"from_m", -deviation.histogram.end_m},
                                {"to_m", deviation.histogram.end_m},
                                {"shares", deviation.histogram.shares},
                                {"share_below", deviation.histogram.share_below},
                                {"share_above", deviation.histogram.share_above}}},
                              {"regions", regions_json(deviation.regions)},
                              {"tolerance", tolerance_json(comparison)},
                              {"reference_is_closed", comparison.compared.reference.edges.border == 0},
                              {"files", files}};
  return json.dump(2, ' ', false, DeviationJson::error_handler_t::replace) + "\n";
}

std::string comparison_lines(const Comparison& comparison) {
  const MeshDeviation& deviation = comparison.compared.deviation;
  std::string text = fmt::format("{} against {} ({} and {} triangles), positive outside of the reference\n",
                                 comparison.mesh.path.string(), comparison.reference.path.string(),
                                 comparison.mesh.triangles, comparison.reference.triangles);
  text += deviation_line("Vertices", deviation.vertices) + deviation_line("Area", deviation.area) +
          deviation_line("Reference", deviation.reference_area) + worst_region_line(deviation.regions) +
          tolerance_line(comparison);
  for (const auto& file : comparison.files) text += fmt::format("Written     {}\n", file.string());
  return text;
}

}  // namespace scanknit
