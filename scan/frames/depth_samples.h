// DepthSamples: some depth frames of a scan, evenly taken however long it becomes, to compare the mesh with.
#pragma once

#include <cstdint>
#include <vector>

#include "core/frame.h"
#include "export/picture/surface_fit.h"
#include "scan/trajectory.h"

namespace scanknit {

class DepthSamples {
 public:
  /// A frame that was fused, filtered as it was fused. Every one is kept until there are 48; then every second of them
  /// is let go, and so on. Pictures are thinned out to at most 320 columns.
  void add(const Frame& frame);
  void clear();

  /// Those that the trajectory has a pose for. Refers to the samples' pictures.
  [[nodiscard]] std::vector<PosedDepth> posed(const Trajectory& trajectory) const;

 private:
  struct Sample {
    std::uint64_t sequence;
    DepthImage depth_m;
    CameraIntrinsics intrinsics;
  };
  std::vector<Sample> samples_;
  std::size_t seen_ = 0, every_ = 1;
};

}  // namespace scanknit
