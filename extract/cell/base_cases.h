// The base cases: the 15 configurations of Lorensen & Cline 1987, triangulated by hand.
#pragma once

#include <array>
#include <initializer_list>

#include "extract/cell/packed_triangles.h"

namespace scanknit {

/// How a base case resolves its ambiguous faces.
enum class Resolution : std::uint8_t {
  kUnambiguous,
  kHighsSeparated,  ///< on its one ambiguous face
  kHighsJoined,     ///< on its one ambiguous face
  kTraced,          ///< several ambiguous faces: its contours are traced (contours.h); no triangles here
};

/// One configuration, in one resolution: which corners are High, and the triangles on crossed edges, counter-clockwise
/// seen from the Lows. No side of a triangle lies in a face of the cell unless the isosurface meets the face there
/// (is_chord_inside_cell).
struct BaseCase {
  int configuration = 0;  ///< 0 to 14, the lecture's numbers
  Resolution resolution = Resolution::kUnambiguous;
  CornerMask highs = 0;
  PackedTriangles triangles;
};

[[nodiscard]] constexpr CornerMask corners(std::initializer_list<int> highs) {
  unsigned mask = 0;
  for (const int corner : highs) mask |= 1u << corner;
  return static_cast<CornerMask>(mask);
}

[[nodiscard]] constexpr CornerMask all_but(std::initializer_list<int> lows) {
  return colour_flipped(corners(lows));
}

/// A chain of four corners that bends out of the plane; it and its mirror image are configurations 11 and 14.
/// (Which is which follows Lorensen's own pictures of the cases, in VTK's MarchingCases example.)
inline constexpr BaseCase kChain{
    11, Resolution::kUnambiguous, corners({0, 4, 5, 7}), {{0, 4, 11}, {4, 6, 11}, {0, 11, 9}, {6, 3, 11}}};

/// Colour flip keeps the triangles but swaps the two resolutions of an ambiguous face; so those configurations stand
/// here with few Highs and with few Lows, each in both resolutions.
inline constexpr std::array kBaseCases{
    BaseCase{0, Resolution::kUnambiguous, corners({}), {}},
    BaseCase{1, Resolution::kUnambiguous, corners({0}), {{0, 4, 8}}},
    BaseCase{2, Resolution::kUnambiguous, corners({0, 1}), {{4, 8, 5}, {8, 9, 5}}},
    BaseCase{3, Resolution::kHighsSeparated, corners({0, 3}), {{0, 4, 8}, {1, 5, 11}}},
    BaseCase{3, Resolution::kHighsJoined, corners({0, 3}), {{0, 11, 8}, {0, 5, 11}, {11, 1, 8}, {1, 4, 8}}},
    BaseCase{3, Resolution::kHighsSeparated, all_but({0, 3}), {{0, 8, 11}, {0, 11, 5}, {11, 8, 1}, {1, 8, 4}}},
    BaseCase{3, Resolution::kHighsJoined, all_but({0, 3}), {{0, 8, 4}, {1, 11, 5}}},
    BaseCase{4, Resolution::kUnambiguous, corners({0, 7}), {{0, 4, 8}, {3, 11, 7}}},
    BaseCase{5, Resolution::kUnambiguous, corners({0, 1, 2}), {{1, 8, 5}, {1, 10, 8}, {8, 9, 5}}},
    BaseCase{6, Resolution::kHighsSeparated, corners({0, 1, 6}), {{3, 6, 10}, {4, 8, 5}, {8, 9, 5}}},
    BaseCase{
        6, Resolution::kHighsJoined, corners({0, 1, 6}), {{3, 9, 10}, {3, 6, 9}, {6, 8, 9}, {9, 5, 10}, {5, 4, 10}}},
    BaseCase{
        6, Resolution::kHighsSeparated, all_but({0, 1, 6}), {{3, 10, 9}, {3, 9, 6}, {6, 9, 8}, {9, 10, 5}, {5, 10, 4}}},
    BaseCase{6, Resolution::kHighsJoined, all_but({0, 1, 6}), {{3, 10, 6}, {4, 5, 8}, {8, 5, 9}}},
    BaseCase{7, Resolution::kTraced, corners({0, 3, 5}), {}},
    BaseCase{7, Resolution::kTraced, all_but({0, 3, 5}), {}},
    BaseCase{8, Resolution::kUnambiguous, corners({0, 1, 2, 3}), {{8, 9, 10}, {9, 11, 10}}},
    BaseCase{9, Resolution::kUnambiguous, corners({0, 1, 2, 4}), {{1, 6, 5}, {1, 10, 6}, {6, 2, 5}, {2, 9, 5}}},
    BaseCase{10, Resolution::kTraced, corners({0, 1, 6, 7}), {}},
    kChain,
    BaseCase{12, Resolution::kTraced, corners({0, 1, 2, 7}), {}},
    BaseCase{13, Resolution::kTraced, corners({0, 3, 5, 6}), {}},
    BaseCase{14, Resolution::kUnambiguous, transformed(kChain.highs, kMirrorX),
             transformed(kChain.triangles, kMirrorX)},
};

}  // namespace scanknit
