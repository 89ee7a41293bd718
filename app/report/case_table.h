// A table of how often each configuration and sub-case of cells occurred.
#pragma once

#include <string>

#include "extract/cell/case_counts.h"

namespace scanknit {

/// One row for each sub-case, also for those that did not occur: its cells, and their share of all cells and of the
/// cells that the surface crosses.
[[nodiscard]] std::string case_table_text(const CaseCounts& counts);

}  // namespace scanknit
