#include "app/terminal/case_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace scanknit {
namespace {

double per_cent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

std::string case_table_text(const RunReport::Extract& extract) {
  if (extract.sub_cases.empty()) return "Cases    none: tetrahedra have no configurations of the cube\n";
  std::size_t cells = 0, crossed = 0, width = 8;
  for (const auto& [name, count] : extract.sub_cases) {
    cells += count;
    crossed += name == "0" ? 0 : count;
    width = std::max(width, name.size());
  }
  std::string text = fmt::format("{:{}}  {:>14}  {:>10}  {:>12}\n", "Case", width, "cells", "% of all", "% of crossed");
  for (const auto& [name, count] : extract.sub_cases) {
    const std::string share = name == "0" ? "" : fmt::format("{:.4f}", per_cent(count, crossed));
    text += fmt::format("{:{}}  {:>14}  {:>10.4f}  {:>12}\n", name, width, count, per_cent(count, cells), share);
  }
  return text;
}

}  // namespace scanknit
