// CaseHistogram: the counts during extraction, by how cells are resolved.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "extract/cell/case_counts.h"
#include "extract/cell/cell_table.h"

namespace scanknit {

/// One counter for each row of the CellTable.
class CaseHistogram {
 public:
  CaseHistogram();
  void add(CellEntry entry) { ++cells_[entry]; }
  /// A case that needs no values.
  void add_simple(CornerMask highs) { ++simple_cells_[highs]; }
  void add_without_surface(std::size_t cells) { without_surface_ += cells; }
  void add_skipped(std::size_t cells) { skipped_ += cells; }
  void add(const CaseHistogram& other);

  /// `is_mirrored`: the blocks' axes are left-handed in the world. 11 and 14 are mirror images of each other.
  [[nodiscard]] CaseCounts counts(bool is_mirrored) const;

 private:
  std::vector<std::size_t> cells_;
  std::array<std::size_t, 256> simple_cells_{};
  std::size_t without_surface_ = 0;
  std::size_t skipped_ = 0;
};

/// The configuration's number; a letter by the number of ambiguous faces on which the corners of the rarer colour (the
/// Highs, where there are four of each) are joined, A for none; and what the interior test found. So 3A and 6A are
/// separated and 3B and 6B joined, 10A and 12A have both faces separated, 10B and 12B one, 10C and 12C none. (The
/// lecture has further letters for arrangements that are the same up to symmetry: B, D.) 13 has A to G.
[[nodiscard]] std::string sub_case_name(int configuration, CornerMask highs, FaceMask joined_faces, bool has_tunnel);

}  // namespace scanknit
