// CaseCounts: how often each configuration and sub-case occurred.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace scanknit {

/// One way in which cells of a configuration were resolved.
struct SubCase {
  int configuration = 0;  ///< 0 to 14, the lecture's numbers
  std::string name;       ///< "0", "3A", "10B", "13D tunnel": letters by the ambiguous faces that are joined
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

}  // namespace scanknit
