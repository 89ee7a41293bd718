// CaseCounts: how often each configuration and sub-case occurred.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "extract/cell/cell_table.h"

namespace scanknit {

/// One way in which cells of a configuration were resolved.
struct SubCase {
  int configuration = 0;  ///< 0 to 14, the lecture's numbers
  std::string name;       ///< "0", "3A", "10B", "13D tunnel": see sub_case_name
  std::size_t cells = 0;
};

struct CaseCounts {
  std::vector<SubCase> sub_cases;          ///< by configuration; those with a tunnel only if they occurred
  std::size_t ambiguous_faces_joined = 0;  ///< the Highs are joined; a face of two cells counts twice
  std::size_t ambiguous_faces_separated = 0;
  std::size_t tunnels = 0;
  std::size_t skipped_cells = 0;       ///< cells with observed High and Low corners and an unobserved one
  std::size_t components_removed = 0;  ///< removed because of min_component_triangles

  /// The number of cells of a configuration, 0 to 14.
  [[nodiscard]] std::size_t of_configuration(int configuration) const;
};

/// The counts during extraction: one counter for each row of the CellTable.
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
