// The frequency of each way in which cells were resolved, as a table.
#pragma once

#include <string>

#include "extract/cell/case_counts.h"

namespace scanknit {

/// A row for each sub-case, met or not: its cells, and their share of all cells and of those that the surface crosses.
[[nodiscard]] std::string case_table_text(const CaseCounts& counts);

}  // namespace scanknit
