#include "finish/mesh_steps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh_area.h"
#include "core/mesh/mesh_pieces.h"
#include "finish/mesh_edges.h"

namespace scanknit {
PiecesRemoved remove_small_pieces(double min_share, double min_size_m, Mesh& mesh) {
  struct Piece {
    double area_m2 = 0;
    std::size_t triangles = 0;
    Eigen::AlignedBox3f box;
  };
  DisjointSets sets = pieces_of(mesh);
  std::vector<Piece> pieces(mesh.positions_m.size());  // by root
  for (const Triangle& t : mesh.triangles) {
    Piece& piece = pieces[sets.root(t[0])];
    piece.area_m2 += area_vector_m2(mesh, t).norm();
    ++piece.triangles;
    for (const std::uint32_t vertex : t) piece.box.extend(mesh.positions_m[vertex]);
  }
  const auto largest = std::max_element(pieces.begin(), pieces.end(),
                                        [](const Piece& a, const Piece& b) { return a.area_m2 < b.area_m2; });
  PiecesRemoved removed;
  std::vector<std::uint8_t> keeps_piece(pieces.size(), 1);
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece) {
    if (piece->triangles == 0 || piece == largest) continue;
    const bool is_small =
        piece->area_m2 < min_share * largest->area_m2 || static_cast<double>(piece->box.diagonal().norm()) < min_size_m;
    if (!is_small) continue;
    keeps_piece[static_cast<std::size_t>(piece - pieces.begin())] = 0;
    ++removed.pieces;
    removed.triangles += piece->triangles;
    removed.area_m2 += piece->area_m2;
  }
  if (removed.pieces == 0) return removed;
  std::vector<std::uint8_t> keeps;
  keeps.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) keeps.push_back(keeps_piece[sets.root(t[0])]);
  keep_triangles(keeps, mesh);
  return removed;
}

PiecesRemoved count_removed(const Mesh& mesh, const std::vector<std::uint8_t>& is_left_out) {
  PiecesRemoved removed;
  DisjointSets sets = pieces_of(mesh);
  std::vector<std::uint8_t> loses(mesh.positions_m.size());  // by root
  std::vector<std::uint8_t> stays(mesh.positions_m.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    (is_left_out[i] != 0 ? loses : stays)[sets.root(t[0])] = 1;
    if (is_left_out[i] == 0) continue;
    ++removed.triangles;
    removed.area_m2 += area_vector_m2(mesh, t).norm();
  }
  for (std::size_t root = 0; root < loses.size(); ++root) {
    if (loses[root] != 0 && stays[root] == 0) ++removed.pieces;
  }
  return removed;
}

}  // namespace scanknit
