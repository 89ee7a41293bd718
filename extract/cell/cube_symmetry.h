// The symmetries of a cell: the 24 rotations, the reflection that doubles them, and the change of colour.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "extract/cell/cell.h"

namespace scanknit {

/// Where a symmetry takes each corner and each edge: two lookup tables.
struct CubeSymmetry {
  std::array<std::uint8_t, kCorners> corner{};
  std::array<EdgeIndex, kEdges> edge{};
  bool is_mirror = false;  ///< turns counter-clockwise into clockwise

  constexpr bool operator==(const CubeSymmetry&) const = default;
};

/// The symmetry that takes the corner (x, y, z) to move(x, y, z).
template <typename Move>
[[nodiscard]] constexpr CubeSymmetry make_symmetry(Move move, bool is_mirror) {
  CubeSymmetry symmetry;
  symmetry.is_mirror = is_mirror;
  for (int i = 0; i < kCorners; ++i) {
    const std::array<int, 3> to = move(corner_coordinate(i, 0), corner_coordinate(i, 1), corner_coordinate(i, 2));
    symmetry.corner[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(to[0] + 2 * to[1] + 4 * to[2]);
  }
  for (int e = 0; e < kEdges; ++e) {
    symmetry.edge[static_cast<std::size_t>(e)] =
        static_cast<EdgeIndex>(edge_between(symmetry.corner[static_cast<std::size_t>(edge_low_corner(e))],
                                            symmetry.corner[static_cast<std::size_t>(edge_high_corner(e))]));
  }
  return symmetry;
}

/// The generators: a quarter turn about x, a third of a turn about the diagonal, and x -> -x.
inline constexpr CubeSymmetry kIdentity = make_symmetry([](int x, int y, int z) { return std::array{x, y, z}; }, false);
inline constexpr CubeSymmetry kRotateX = make_symmetry(
    [](int x, int y, int z) {
      return std::array{x, 1 - z, y};
    },
    false);
inline constexpr CubeSymmetry kRotateDiagonal = make_symmetry(
    [](int x, int y, int z) {
      return std::array{z, x, y};
    },
    false);
inline constexpr CubeSymmetry kMirrorX = make_symmetry(
    [](int x, int y, int z) {
      return std::array{1 - x, y, z};
    },
    true);

/// First `first`, then `second`.
[[nodiscard]] constexpr CubeSymmetry compose(const CubeSymmetry& second, const CubeSymmetry& first) {
  CubeSymmetry both;
  both.is_mirror = first.is_mirror != second.is_mirror;
  for (std::size_t i = 0; i < kCorners; ++i) both.corner[i] = second.corner[first.corner[i]];
  for (std::size_t e = 0; e < kEdges; ++e) both.edge[e] = second.edge[first.edge[e]];
  return both;
}

/// All that the two rotations generate. (With the change of colour these are the lecture's 8 * 3 * 2 = 48; with the
/// reflection 96.) An array too small for the group would not compile; one too large fails the assertion.
inline constexpr auto kRotations = [] {
  std::array<CubeSymmetry, 24> group{kIdentity};
  std::size_t size = 1;
  for (std::size_t i = 0; i < size; ++i) {
    for (const CubeSymmetry& generator : {kRotateX, kRotateDiagonal}) {
      const CubeSymmetry next = compose(generator, group[i]);
      const auto known = group.begin() + static_cast<std::ptrdiff_t>(size);
      if (std::find(group.begin(), known, next) == known) group[size++] = next;
    }
  }
  return group;
}();
static_assert(kRotations.back() != CubeSymmetry{}, "the rotations of the cube are 24");

[[nodiscard]] constexpr CornerMask transformed(CornerMask highs, const CubeSymmetry& symmetry) {
  unsigned moved = 0;
  for (int i = 0; i < kCorners; ++i) {
    if (is_high(highs, i)) moved |= 1u << symmetry.corner[static_cast<std::size_t>(i)];
  }
  return static_cast<CornerMask>(moved);
}

[[nodiscard]] constexpr CornerMask colour_flipped(CornerMask highs) {
  return static_cast<CornerMask>(~highs);
}

}  // namespace scanknit
