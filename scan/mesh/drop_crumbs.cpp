#include "scan/mesh/drop_crumbs.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/mesh/unused_vertices.h"

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

std::vector<Confirmation> confirmations(const Mesh& points, std::span<const PosedDepth> frames, const FitBand& band) {
  const std::vector<std::uint16_t> readings = fit_surface(points, frames, band).seen_by;
  const std::vector<std::uint16_t> views = fit_surface(points, frames, one_sigma_of(band)).seen_by;
  std::vector<Confirmation> confirmed;
  for (std::size_t i = 0; i < views.size(); ++i) confirmed.push_back({readings[i], views[i]});
  return confirmed;
}

/// Of all vertices: those of large pieces are confirmed. Empty: there are no small ones.
std::vector<Confirmation> confirmations_of(const Mesh& mesh, std::span<const PosedDepth> frames, const FitBand& band) {
  const std::vector<std::uint32_t> vertices = vertices_of_small_pieces(kSmallShare, mesh);
  if (vertices.empty()) return {};
  Mesh points;
  for (const std::uint32_t vertex : vertices) {
    points.positions_m.push_back(mesh.positions_m[vertex]);
    points.normals.push_back(mesh.normals[vertex]);
  }
  constexpr std::uint16_t kAll = std::numeric_limits<std::uint16_t>::max();
  const std::vector<Confirmation> confirmed = confirmations(points, frames, band);
  std::vector<Confirmation> of_all(mesh.positions_m.size(), Confirmation{kAll, kAll});
  for (std::size_t i = 0; i < vertices.size(); ++i) of_all[vertices[i]] = confirmed[i];
  return of_all;
}

}  // namespace

PiecesRemoved drop_crumbs(std::span<const PosedDepth> frames, const FitBand& band, Mesh& mesh) {
  if (frames.empty() || mesh.normals.size() != mesh.positions_m.size()) return {};
  PiecesRemoved removed;
  if (const std::vector<Confirmation> confirmed = confirmations_of(mesh, frames, band); !confirmed.empty()) {
    const double least_views = std::min(kViews, kShareOfFrames * static_cast<double>(frames.size()));
    removed = remove_unconfirmed_pieces(confirmed, least_views, kShareOfReadings, mesh);
  }
  return_unused_memory(mesh);
  return removed;
}

}  // namespace scanknit
