// ExtractConfig: how a volume becomes a mesh. The keys of `extract:` in YAML.
#pragma once

#include <cstddef>

namespace scanknit {

/// How the contours of ambiguous faces are joined.
enum class Decider {
  kAsymptotic,  ///< Nielson & Hamann 1991: joined iff the face saddle is High
};

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
  Decider decider = Decider::kAsymptotic;
  VertexPlacement placement = VertexPlacement::kLinear;
  InsideSide inside = InsideSide::kAuto;
  bool normals = true;                      ///< from the gradient of the volume
  double min_weight = 0;                    ///< samples observed with less weight count as unobserved
  std::size_t min_component_triangles = 0;  ///< smaller pieces are removed; 0: keep all
};

}  // namespace scanknit
