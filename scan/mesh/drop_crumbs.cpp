#include "scan/mesh/drop_crumbs.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/mesh/unused_vertices.h"
#include "core/system/freed_memory.h"

namespace scanknit {
namespace {

constexpr double kSmallShare = 0.1;  // of the largest piece's area
constexpr double kViews = 3;
constexpr double kShareOfFrames = 0.125;
constexpr double kShareOfReadings = 0.5;

/// `band`, narrowed to readings of this very surface: a quarter of its least width is one voxel.
FitBand one_sigma_of(const FitBand& band) {
  return {band.least_m / 4, 1, band.noise};
}

std::vector<Confirmation> confirmations_of(std::span<const std::uint32_t> vertices, const Mesh& mesh,
                                           std::span<const PosedDepth> frames, const FitBand& band) {
  Mesh points;
  for (const std::uint32_t vertex : vertices) {
    points.positions_m.push_back(mesh.positions_m[vertex]);
    points.normals.push_back(mesh.normals[vertex]);
  }
  const std::vector<std::uint16_t> readings = fit_surface(points, frames, band).seen_by;
  const std::vector<std::uint16_t> views = fit_surface(points, frames, one_sigma_of(band)).seen_by;
  std::vector<Confirmation> confirmed;
  for (std::size_t i = 0; i < views.size(); ++i) confirmed.push_back({readings[i], views[i]});
  return confirmed;
}

}  // namespace

PiecesRemoved drop_crumbs(std::span<const PosedDepth> frames, const FitBand& band, Mesh& mesh) {
  if (frames.empty() || mesh.normals.size() != mesh.positions_m.size()) return {};
  const double least_views = std::min(kViews, kShareOfFrames * static_cast<double>(frames.size()));
  const PiecesRemoved removed = remove_unconfirmed_pieces(
      kSmallShare,
      [&](std::span<const std::uint32_t> vertices) { return confirmations_of(vertices, mesh, frames, band); },
      least_views, kShareOfReadings, mesh);
  return_freed_memory();
  return_unused_memory(mesh);
  return removed;
}

}  // namespace scanknit
