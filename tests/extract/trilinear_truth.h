// The topology of the trilinear isosurface by exact integer arithmetic. No marching-cubes table: a sweep along x
// through each cell, independent of the code under test. Only the numbering of corners, edges and faces is shared
// (cell.h).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "extract/cell/cell.h"

namespace scanknit::test {

/// Values of larger magnitude would overflow the 128-bit products of four of them.
inline constexpr std::int64_t kLargestTruthValue = std::int64_t{1} << 29;

/// A sample of a volume that makes its cells be skipped.
inline constexpr std::int64_t kUnobserved = INT64_MIN;

struct CellTruth {
  int components = 0;  ///< of the surface
  int euler = 0;       ///< of the surface, with its boundary
  int contours = 0;    ///< closed curves in the cell's boundary
  int high_regions = 0;
  int low_regions = 0;
  std::array<int, kEdges> edge_component{};  ///< the surface component through each crossed edge; -1: not crossed
  std::array<char, kFaces> faces{};          ///< '.' not ambiguous, 'H' Highs joined, 'L' Lows joined
};

/// Isovalue 0; `values` in cell.h's order of corners, magnitude at most kLargestTruthValue. Ties are resolved as if
/// every value were larger by an infinitesimal: a corner or saddle of value 0 is High.
[[nodiscard]] CellTruth trilinear_truth(const std::array<std::int64_t, kCorners>& values);

struct VolumeTruth {
  int components = 0;
  int euler = 0;     ///< of the surface, with its boundary
  int vertices = 0;  ///< crossed grid edges, counted once for each fan of whole cells round them
};

/// The isosurface in all cells of a volume without a sample kUnobserved. `values[(x dims[1] + y) dims[2] + z]`. Where
/// skipped cells pinch the surface at a grid edge, it is split.
[[nodiscard]] VolumeTruth trilinear_truth(std::span<const std::int64_t> values, const std::array<int, 3>& dims);

}  // namespace scanknit::test
