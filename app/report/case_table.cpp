#include "app/report/case_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace scanknit {
namespace {

double per_cent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

std::string case_table_text(const CaseCounts& counts) {
  if (counts.sub_cases.empty()) return "Cases    none: tetrahedra have no configurations of the cube\n";
  std::size_t cells = 0, crossed = 0, width = 8;
  for (const SubCase& sub_case : counts.sub_cases) {
    cells += sub_case.cells;
    crossed += sub_case.name == "0" ? 0 : sub_case.cells;
    width = std::max(width, sub_case.name.size());
  }
  std::string text = fmt::format("{:{}}  {:>14}  {:>10}  {:>12}\n", "Case", width, "cells", "% of all", "% of crossed");
  for (const SubCase& sub_case : counts.sub_cases) {
    const std::string share = sub_case.name == "0" ? "" : fmt::format("{:.4f}", per_cent(sub_case.cells, crossed));
    text += fmt::format("{:{}}  {:>14}  {:>10.4f}  {:>12}\n", sub_case.name, width, sub_case.cells,
                        per_cent(sub_case.cells, cells), share);
  }
  return text;
}

}  // namespace scanknit
