// The table of the 256 cases, filled from the base cases by the symmetries of the cube.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "extract/cell/base_cases.h"

namespace scanknit {

/// 4 KB of triangles: both resolutions of the cases with one ambiguous face; the others have the same word twice.
struct CaseTable {
  std::array<std::array<PackedTriangles, 2>, 256> triangles{};  ///< [highs][the one ambiguous face is joined]
  std::array<std::uint8_t, 256> configuration{};                ///< 0 to 14
  std::array<std::array<bool, 2>, 256> is_filled{};
};

/// Enters a case and, once each, everything that the rotations and the change of colour make of it.
constexpr void fill(CaseTable& table, const BaseCase& entry) {
  const bool is_joined = entry.resolution == Resolution::kHighsJoined;
  if (table.is_filled[entry.highs][is_joined]) return;
  const bool is_resolved = is_joined || entry.resolution == Resolution::kHighsSeparated;
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    if (is_resolved && i != (is_joined ? 1u : 0u)) continue;
    table.triangles[entry.highs][i] = entry.triangles;
    table.is_filled[entry.highs][i] = true;
  }
  table.configuration[entry.highs] = static_cast<std::uint8_t>(entry.configuration);

  for (const CubeSymmetry& generator : {kRotateX, kRotateDiagonal}) {
    fill(table, {entry.configuration, entry.resolution, transformed(entry.highs, generator),
                 transformed(entry.triangles, generator)});
  }
  if (kAmbiguousFaces[entry.highs] != 0) return;  // a change of colour would turn joined Highs into joined Lows
  fill(table, {entry.configuration, entry.resolution, colour_flipped(entry.highs), colour_flipped(entry.triangles)});
}

inline constexpr CaseTable kCaseTable = [] {
  CaseTable table;
  for (const BaseCase& base_case : kBaseCases) fill(table, base_case);
  return table;
}();

/// The table knows the triangles of this case: at most one of its faces is ambiguous.
[[nodiscard]] constexpr bool is_tabulated(CornerMask highs) {
  return std::has_single_bit(kAmbiguousFaces[highs]) || kAmbiguousFaces[highs] == 0;
}

static_assert(
    [] {
      for (unsigned highs = 0; highs < 256; ++highs) {
        const bool has_surface = highs != 0 && highs != 255;
        for (const std::size_t joined : {0u, 1u}) {
          const bool has_triangles = kCaseTable.triangles[highs][joined].size() > 0;
          const bool expects_triangles = has_surface && is_tabulated(static_cast<CornerMask>(highs));
          if (!kCaseTable.is_filled[highs][joined] || has_triangles != expects_triangles) return false;
        }
      }
      return true;
    }(),
    "the base cases and the symmetries reach all 256 cases");

}  // namespace scanknit
