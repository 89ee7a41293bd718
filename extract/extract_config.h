// ExtractConfig: how a volume becomes a mesh. The keys of `extract:` in YAML. VolumeOptions: how its file is read.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>

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

/// True for the tetrahedral deciders, which have no ambiguity.
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

/// True where matter is High. kAuto depends on what the volume holds.
[[nodiscard]] constexpr bool is_inside_high(InsideSide inside, bool is_signed_distance) {
  return inside == InsideSide::kAuto ? !is_signed_distance : inside == InsideSide::kHigh;
}

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

/// How a volume's file stores a sample.
enum class SampleType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kInt64, kUint64, kFloat, kDouble };
enum class ByteOrder { kLittle, kBig };

inline constexpr std::size_t kDefaultVolumeBudget = std::size_t{4} << 30;

/// What a volume's file does not say of itself.
struct VolumeOptions {
  std::optional<Eigen::Vector3i> dims;        ///< raw files: samples along i (fastest), j, k
  std::optional<SampleType> type;             ///< raw files
  std::optional<Eigen::Vector3d> spacing;     ///< raw files and image stacks: mm, > 0
  ByteOrder byte_order = ByteOrder::kLittle;  ///< raw files
  std::uint64_t header_bytes = 0;             ///< raw files: bytes before the first sample
  /// What the reader may hold in memory: the decoded samples where a format must be decoded whole, else a slice.
  std::size_t memory_budget_bytes = kDefaultVolumeBudget;
};

}  // namespace scanknit
