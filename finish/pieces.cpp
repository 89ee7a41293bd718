#include "finish/mesh_steps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/check.h"
#include "core/mesh/mesh_area.h"
#include "core/mesh/mesh_pieces.h"
#include "core/mesh/unused_vertices.h"
#include "finish/mesh_edges.h"

namespace scanknit {
namespace {

/// The pieces of a mesh, in the order of their first vertices. A vertex that no triangle uses is a piece, too.
class Pieces {
 public:
  struct Piece {
    double area_m2 = 0;
    std::size_t triangles = 0;
    Eigen::AlignedBox3f box;
  };

  explicit Pieces(const Mesh& mesh) : number_(mesh.positions_m.size()) {
    DisjointSets sets = pieces_of(mesh);
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < number_.size(); ++i) {
      const std::uint32_t root = sets.root(i);  // the piece's smallest number
      number_[i] = root == i ? count++ : number_[root];
    }
    pieces_.resize(count);
    for (const Triangle& t : mesh.triangles) {
      Piece& piece = pieces_[of(t[0])];
      piece.area_m2 += area_vector_m2(mesh, t).norm();
      ++piece.triangles;
      for (const std::uint32_t vertex : t) piece.box.extend(mesh.positions_m[vertex]);
    }
    largest_ = static_cast<std::size_t>(
        std::max_element(pieces_.begin(), pieces_.end(),
                         [](const Piece& a, const Piece& b) { return a.area_m2 < b.area_m2; }) -
        pieces_.begin());
  }

  [[nodiscard]] std::size_t count() const { return pieces_.size(); }
  [[nodiscard]] std::size_t of(std::uint32_t vertex) const { return number_[vertex]; }
  [[nodiscard]] const Piece& operator[](std::size_t number) const { return pieces_[number]; }
  [[nodiscard]] double largest_area_m2() const { return pieces_.empty() ? 0 : pieces_[largest_].area_m2; }

  [[nodiscard]] bool is_small(std::size_t number, double min_share, double min_size_m) const {
    const Piece& piece = pieces_[number];
    return piece.area_m2 < min_share * largest_area_m2() ||
           static_cast<double>(piece.box.diagonal().norm()) < min_size_m;
  }
  /// Removes from the mesh the pieces that `goes` says; the largest stays.
  template <typename Goes>
  PiecesRemoved remove(Mesh& mesh, Goes&& goes) {
    PiecesRemoved removed;
    std::vector<std::uint8_t> keeps_piece(pieces_.size(), 1);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      if (pieces_[i].triangles == 0 || i == largest_ || !goes(i)) continue;
      keeps_piece[i] = 0;
      ++removed.pieces;
      removed.triangles += pieces_[i].triangles;
      removed.area_m2 += pieces_[i].area_m2;
    }
    if (removed.pieces == 0) return removed;
    std::erase_if(mesh.triangles, [&](const Triangle& t) { return keeps_piece[of(t[0])] == 0; });
    drop_unused_vertices(mesh);
    return removed;
  }

 private:
  std::vector<std::uint32_t> number_;  ///< by vertex
  std::vector<Piece> pieces_;
  std::size_t largest_ = 0;
};

}  // namespace

PiecesRemoved remove_small_pieces(double min_share, double min_size_m, Mesh& mesh) {
  Pieces pieces(mesh);
  return pieces.remove(mesh, [&](std::size_t i) { return pieces.is_small(i, min_share, min_size_m); });
}

PiecesRemoved remove_unconfirmed_pieces(double max_share, const ConfirmationsOf& confirmations_of, double least_views,
                                        double least_share, Mesh& mesh) {
  constexpr std::size_t kAtOnce = 65'536;
  struct Sums {
    double vertices = 0, readings = 0, views = 0;  // whole numbers: exact in any order
  };
  Pieces pieces(mesh);
  std::vector<Sums> sums(pieces.count());
  std::vector<std::uint32_t> asked;
  const auto add_asked = [&] {
    const std::vector<Confirmation> confirmed = confirmations_of(asked);
    SCANKNIT_CHECK(confirmed.size() == asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) {
      Sums& of_piece = sums[pieces.of(asked[i])];
      ++of_piece.vertices;
      of_piece.readings += confirmed[i].readings;
      of_piece.views += confirmed[i].views;
    }
    asked.clear();
  };
  for (std::uint32_t i = 0; i < mesh.positions_m.size(); ++i) {
    if (!(pieces[pieces.of(i)].area_m2 < max_share * pieces.largest_area_m2())) continue;
    asked.push_back(i);
    if (asked.size() == kAtOnce) add_asked();
  }
  if (!asked.empty()) add_asked();
  return pieces.remove(mesh, [&](std::size_t i) {  // the sums of large pieces are zero: they stay
    return sums[i].views < least_views * sums[i].vertices || sums[i].views < least_share * sums[i].readings;
  });
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
