#include "extract/resolve_cell.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "extract/cell/face_decider.h"
#include "extract/cell/knit_value.h"
#include "extract/reference/lorensen.h"

namespace scanknit {
namespace {

/// The eight samples of the cell at (x, y, z).
CellValues corner_values(const ValueBlock& values, int x, int y, int z) {
  CellValues corners;
  for (int i = 0; i < kCorners; ++i) {
    corners[static_cast<std::size_t>(i)] = static_cast<double>(
        values.at(x + corner_coordinate(i, 0), y + corner_coordinate(i, 1), z + corner_coordinate(i, 2)));
  }
  return corners;
}

/// The ambiguous faces for which joins_highs(face) is true.
template <typename JoinsHighs>
FaceMask joined_faces(CornerMask highs, const JoinsHighs& joins_highs) {
  unsigned joined = 0;
  for (unsigned faces = kAmbiguousFaces[highs]; faces != 0; faces &= faces - 1) {
    const auto face = static_cast<std::size_t>(std::countr_zero(faces));
    if (joins_highs(face)) joined |= 1u << face;
  }
  return static_cast<FaceMask>(joined);
}

template <FaceDecision (*decide)(const FaceValues&)>
FaceMask decide_faces(const CellValues& corners, CornerMask highs) {
  return joined_faces(highs, [&](std::size_t face) {
    FaceValues value;
    for (std::size_t i = 0; i < 4; ++i) value[i] = corners[static_cast<std::size_t>(kFaceRing[face][i])];
    return decide(value) == FaceDecision::kHighsJoined;
  });
}

/// The higher of the two levels at which the Highs of `face` are connected through the cells that share it; through the
/// one cell that there is where the other is not observed.
double knit_level(const ValueBlock& values, const Eigen::Vector3i& cell, std::size_t face, CornerMask highs) {
  const int axis = static_cast<int>(face) / 2;
  const int across = face % 2 == 0 ? -1 : 1;
  const auto& ring = kFaceRing[face];
  const std::size_t first_high = is_high(highs, ring[0]) ? 0 : 1;
  double level = -std::numeric_limits<double>::infinity();
  for (const bool is_neighbour : {false, true}) {
    const Eigen::Vector3i at = cell + (is_neighbour ? across : 0) * Eigen::Vector3i::Unit(axis);
    const CellValues corners = corner_values(values, at.x(), at.y(), at.z());
    if (!std::all_of(corners.begin(), corners.end(), [](double v) { return std::isfinite(v); })) continue;
    const int turn = is_neighbour ? 1 << axis : 0;  // the face is the neighbour's opposite one
    level = std::max(level, knit_value<3>(corners, ring[first_high] ^ turn, ring[first_high + 2] ^ turn));
  }
  return level;
}

}  // namespace

CellEntry resolve_cell(const ValueBlock& values, int x, int y, int z, CornerMask highs, double isovalue,
                       Decider decider) {
  const CellTable& table = CellTable::get();
  CellValues corners = corner_values(values, x, y, z);
  for (double& corner : corners) corner -= isovalue;
  FaceMask joined = 0;
  switch (decider) {
    case Decider::kTrilinear: {
      joined = decide_faces<decide_face>(corners, highs);
      const CellEntry entry = table.entry(highs, joined);
      if (!kMayHaveTunnel[highs]) return entry;
      const auto tunnel = find_tunnel(corners, highs, joined);
      return tunnel ? table.with_tunnel(entry, *tunnel) : entry;
    }
    case Decider::kAsymptotic: joined = decide_faces<decide_face>(corners, highs); break;
    case Decider::kChord: joined = decide_faces<decide_face_by_chord>(corners, highs); break;
    case Decider::kKnit:
      joined = joined_faces(highs, [&](std::size_t face) {
        return isovalue <= knit_level(values, {x, y, z}, face, highs);  // above that level the Lows are joined
      });
      break;
    case Decider::kFixedHigh: joined = kAmbiguousFaces[highs]; break;
    case Decider::kLorensen: joined = lorensen_joined_faces(highs); break;
    case Decider::kFixedLow:
    case Decider::kTetra5:
    case Decider::kTetra6:
    case Decider::kTetra24: break;
  }
  return table.entry(highs, joined);
}

}  // namespace scanknit
