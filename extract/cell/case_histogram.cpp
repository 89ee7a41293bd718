#include "extract/cell/case_histogram.h"

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

namespace scanknit {

std::string sub_case_name(int configuration, CornerMask highs, FaceMask joined_faces, bool has_tunnel) {
  const int ambiguous = std::popcount(kAmbiguousFaces[highs]);
  const int joined = std::popcount(static_cast<FaceMask>(joined_faces & kAmbiguousFaces[highs]));
  std::string name = std::to_string(configuration);
  if (ambiguous > 0) name += static_cast<char>('A' + (std::popcount(highs) > 4 ? ambiguous - joined : joined));
  return has_tunnel ? name + " tunnel" : name;
}

CaseHistogram::CaseHistogram() : cells_(CellTable::get().size(), 0) {}

void CaseHistogram::add(const CaseHistogram& other) {
  for (std::size_t i = 0; i < cells_.size(); ++i) cells_[i] += other.cells_[i];
  for (std::size_t i = 0; i < simple_cells_.size(); ++i) simple_cells_[i] += other.simple_cells_[i];
  without_surface_ += other.without_surface_;
  skipped_ += other.skipped_;
}

CaseCounts CaseHistogram::counts(bool is_mirrored) const {
  const CellTable& table = CellTable::get();
  CaseCounts counts;
  std::map<std::pair<int, std::string>, std::size_t> by_name;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const auto entry = static_cast<CellEntry>(i);
    const CornerMask highs = table.highs(entry);
    const bool is_simple = !table.simple(highs).needs_values;
    const std::size_t cells = is_simple ? simple_cells_[highs] : cells_[i];
    const bool is_plain = highs == 0 || highs == 0xFF;
    const auto ambiguous = static_cast<std::size_t>(std::popcount(kAmbiguousFaces[highs]));
    const auto joined = static_cast<std::size_t>(std::popcount(table.joined_faces(entry)));
    counts.ambiguous_faces_joined += joined * cells;
    counts.ambiguous_faces_separated += (ambiguous - joined) * cells;
    counts.tunnels += table.has_tunnel(entry) ? cells : 0;
    if (table.has_tunnel(entry) && cells == 0) continue;  // many of these do not exist
    const int configuration = kCaseTable.configuration[is_mirrored ? transformed(highs, kMirrorX) : highs];
    const std::string name = sub_case_name(configuration, highs, table.joined_faces(entry), table.has_tunnel(entry));
    by_name[{configuration, name}] += is_plain ? without_surface_ * (highs == 0 ? 1 : 0) : cells;
  }
  for (const auto& [name, cells] : by_name) counts.sub_cases.push_back({name.first, name.second, cells});
  counts.skipped_cells = skipped_;
  return counts;
}

}  // namespace scanknit
