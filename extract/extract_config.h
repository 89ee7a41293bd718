// ExtractConfig: how a volume becomes a mesh. The keys of `extract:` in YAML.
#pragma once

#include <cstddef>
#include <cstdint>

namespace scanknit {

/// How to resolve cells in which the corners' signs leave a choice.
enum class Decider {
  kTrilinear,   ///< the asymptotic decider on faces and the interior test: the topology of the trilinear isosurface
  kAsymptotic,  ///< Nielson & Hamann 1991: a face's Highs are joined iff its saddle is High
  kChord,       ///< iff the crossing of the chords between opposite points is High; agrees with kAsymptotic
  kKnit,       ///< iff they are connected through one of the two cells that share the face (Digital Morse Theory, 1999)
  kFixedHigh,  ///< always
  kFixedLow,   ///< never
  kTetra5,     ///< five tetrahedra a cell, no ambiguity
  kTetra6,     ///< six
  kTetra24,    ///< twenty-four
  kLorensen,   ///< the 15 cases of 1987, each cell by itself: leaves holes; to show the difference only
};

/// True for the tetrahedral deciders, which have no ambiguity and use other code (reference/marching_tetrahedra.h).
[[nodiscard]] constexpr bool is_tetrahedral(Decider decider) {
  return decider == Decider::kTetra5 || decider == Decider::kTetra6 || decider == Decider::kTetra24;
}

enum class VertexPlacement {
  kLinear,   ///< where the linear interpolant along the edge meets the isovalue
  kMidEdge,  ///< in the middle of the edge
};

/// Which side of the isovalue is matter.
enum class InsideSide {
  kAuto,  ///< Low for signed distances (a TSDF, a VDB level set), High for every other volume
  kLow,
  kHigh,
};

struct ExtractConfig {
  double isovalue = 0;  ///< in the volume's own unit: metres for a scan
  Decider decider = Decider::kTrilinear;
  VertexPlacement placement = VertexPlacement::kLinear;
  InsideSide inside = InsideSide::kAuto;
  bool normals = true;                      ///< from the gradient of the volume
  double min_weight = 0;                    ///< samples observed with less weight count as unobserved
  std::size_t min_component_triangles = 0;  ///< remove smaller pieces; 0: keep all
  std::int64_t memory_budget_mib = 4096;    ///< a volume that needs more is read slice by slice
};

}  // namespace scanknit
