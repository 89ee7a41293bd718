#include "export/texture/texture_atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/check.h"
#include "core/mesh/mesh_area.h"
#include "export/texture/atlas_charts.h"
#include "export/texture/atlas_packing.h"

namespace scanknit {
namespace {

constexpr int kLargestChart = 1024;  // texels: smaller ones pack better, and would cut more
constexpr int kMostAttempts = 24;
constexpr double kCoarser = 1.25;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct Box {
  std::int32_t x0 = INT32_MAX, y0 = INT32_MAX, x1 = INT32_MIN, y1 = INT32_MIN;  ///< steps
  void extend(const TexelPoint& p) {
    x0 = std::min(x0, p.x);
    y0 = std::min(y0, p.y);
    x1 = std::max(x1, p.x);
    y1 = std::max(y1, p.y);
  }
  // With the texels on either side that a bilinear filter mixes in.
  [[nodiscard]] int first_x() const { return last_texel(x0); }
  [[nodiscard]] int first_y() const { return last_texel(y0); }
  [[nodiscard]] AtlasBox padded() const {
    return {first_texel(x1) - first_x() + 1 + 2 * kAtlasGutter, first_texel(y1) - first_y() + 1 + 2 * kAtlasGutter};
  }
};

std::vector<Box> boxes_of(const Mesh& mesh, const Charts& charts) {
  std::vector<Box> boxes(charts.planes.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t chart = charts.chart_of[t];
    for (const TexelPoint& p : charts.planes[chart].project(mesh, mesh.triangles[t])) boxes[chart].extend(p);
  }
  return boxes;
}

/// A copy of each vertex for each chart that it belongs to; the first keeps its number.
class VertexCopies {
 public:
  VertexCopies(const Mesh& mesh, const Charts& charts, const std::vector<Box>& boxes, const Packing& packing)
      : mesh_(mesh), charts_(charts), boxes_(boxes), packing_(packing) {
    const std::size_t n = mesh.positions_m.size();
    chart_of_copy_.assign(n, kNone);
    next_copy_.assign(n, kNone);
    atlas_.width = packing.width;
    atlas_.height = packing.height;
    atlas_.charts = charts.planes.size();
    atlas_.places.assign(n, TexelPoint{});
    for (std::uint32_t v = 0; v < n; ++v) atlas_.source.push_back(v);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const std::uint32_t chart = charts.chart_of[t];
      atlas_.triangles.emplace_back(copy(a, chart), copy(b, chart), copy(c, chart));
    }
    atlas_.chart_of = charts.chart_of;
  }

  [[nodiscard]] TextureAtlas take() && { return std::move(atlas_); }

 private:
  [[nodiscard]] std::uint32_t copy(std::uint32_t vertex, std::uint32_t chart) {
    std::uint32_t at = vertex;
    for (; chart_of_copy_[at] != chart; at = next_copy_[at]) {
      if (chart_of_copy_[at] == kNone) return place(at, chart);
      if (next_copy_[at] != kNone) continue;
      const auto added = static_cast<std::uint32_t>(atlas_.source.size());
      next_copy_[at] = added;
      chart_of_copy_.push_back(kNone);
      next_copy_.push_back(kNone);
      atlas_.source.push_back(vertex);
      atlas_.places.emplace_back();
    }
    return at;
  }

  [[nodiscard]] std::uint32_t place(std::uint32_t at, std::uint32_t chart) {
    chart_of_copy_[at] = chart;
    const TexelPoint p = charts_.planes[chart].project(mesh_.positions_m[atlas_.source[at]]);
    constexpr auto kSteps = static_cast<std::int32_t>(kTexelSteps);
    const AtlasPlace& corner = packing_.places[chart];
    atlas_.places[at] = {p.x + (corner.x + kAtlasGutter - boxes_[chart].first_x()) * kSteps,
                         p.y + (corner.y + kAtlasGutter - boxes_[chart].first_y()) * kSteps};
    return at;
  }

  const Mesh& mesh_;
  const Charts& charts_;
  const std::vector<Box>& boxes_;
  const Packing& packing_;
  TextureAtlas atlas_;
  std::vector<std::uint32_t> chart_of_copy_;
  std::vector<std::uint32_t> next_copy_;  ///< of the same vertex
};

std::optional<TextureAtlas> try_atlas(const Mesh& mesh, double texel, int max_side) {
  const Charts charts = grow_charts(mesh, texel, std::min(kLargestChart, max_side - 2 * kAtlasGutter - 2));
  const std::vector<Box> boxes = boxes_of(mesh, charts);
  std::vector<AtlasBox> padded;
  padded.reserve(boxes.size());
  for (const Box& box : boxes) padded.push_back(box.padded());
  const auto packing = pack_boxes(padded, max_side);
  if (!packing) return std::nullopt;
  TextureAtlas atlas = VertexCopies(mesh, charts, boxes, *packing).take();
  atlas.texel = texel;
  return atlas;
}

}  // namespace

Eigen::Vector2f TextureAtlas::coordinate(std::size_t vertex) const {
  const auto share = [](std::int32_t steps, int side) {
    return static_cast<float>((static_cast<double>(steps) / static_cast<double>(kTexelSteps) + 0.5) / side);
  };
  return {share(places[vertex].x, width), share(places[vertex].y, height)};
}

Mesh TextureAtlas::unfolded(const Mesh& mesh) const {
  Mesh made;
  made.triangles = triangles;
  made.positions_m.reserve(source.size());
  for (const std::uint32_t v : source) made.positions_m.push_back(mesh.positions_m[v]);
  if (mesh.normals.empty()) return made;
  made.normals.reserve(source.size());
  for (const std::uint32_t v : source) made.normals.push_back(mesh.normals[v]);
  return made;
}

std::array<TexelPoint, 3> TextureAtlas::corners(std::size_t triangle) const {
  const auto& [a, b, c] = triangles[triangle];
  return {places[a], places[b], places[c]};
}

Result<TextureAtlas> build_atlas(const Mesh& mesh, const AtlasRequest& request) {
  SCANKNIT_CHECK(request.texel > 0 && request.max_side >= 16 && request.max_side <= 16384);
  if (mesh.empty()) return Error{ErrorCode::kMesh, "a mesh without triangles has no texture"};
  // Texels that would not fit even if they were packed without a gap need not be tried.
  const double least = std::sqrt(area_m2(mesh) / 2) / request.max_side;
  double texel = request.may_be_coarser ? std::max(request.texel, least) : request.texel;
  for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
    if (texel >= least) {
      if (auto atlas = try_atlas(mesh, texel, request.max_side)) return *std::move(atlas);
    }
    if (!request.may_be_coarser) {
      return Error{ErrorCode::kBudget,
                   fmt::format("a texture with texels of {:.3g} mm would be larger than {} x {}: take larger texels "
                               "(export.texel_size), a larger export.texture_size, or leave export.texel_size auto",
                               texel * 1000, request.max_side, request.max_side)};
    }
    texel *= kCoarser;
  }
  return Error{ErrorCode::kBudget,
               fmt::format("the mesh has too many triangles for a texture of {} x {}: take a larger "
                           "export.texture_size, simplify the mesh (finish.triangles), or larger voxels",
                           request.max_side, request.max_side)};
}

}  // namespace scanknit
