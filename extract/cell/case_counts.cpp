#include "extract/cell/case_counts.h"

namespace scanknit {

std::size_t CaseCounts::of_configuration(int configuration) const {
  std::size_t cells = 0;
  for (const SubCase& sub_case : sub_cases) cells += sub_case.configuration == configuration ? sub_case.cells : 0;
  return cells;
}

}  // namespace scanknit
