// What PCL does for aligning: in a module, libscanknit_align_pcl.so, since PCL brings many libraries with it.
#pragma once

#include <vector>

#include "core/system/module.h"
#include "fusion/align/local_features.h"

namespace scanknit {

struct AlignPcl {
  /// As surface_features(), of two points or more.
  std::vector<SurfaceFeature> (*describe_points)(const OrientedPoints& points, double radius_m);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const AlignPcl*> load_align_pcl() {
  return load_module<AlignPcl>("align_pcl", "Install scanknit again; it needs Debian's libpcl-features1.13");
}

}  // namespace scanknit
