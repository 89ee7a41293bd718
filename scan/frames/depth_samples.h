// DepthSamples: some depth frames of a scan, to compare the mesh with; evenly spread, however long the scan is.
#pragma once

#include <cstdint>
#include <vector>

#include "core/frame.h"
#include "export/picture/surface_fit.h"
#include "scan/scan_result.h"

namespace scanknit {

class DepthSamples {
 public:
  /// Takes a frame as it was filtered and fused. Keeps every frame until there are 48; then drops every second one and
  /// keeps every second frame from then on, and so on. Thins pictures out to at most 320 columns.
  void add(const Frame& frame);
  void clear();

  /// Frame::sequence of those that are kept.
  [[nodiscard]] std::vector<std::uint64_t> sequences() const;

  /// Of so many frames, it keeps every n-th in the end, beginning with the first. Returns n.
  [[nodiscard]] static std::size_t spacing(std::size_t frames);

  /// The samples that have a pose in the trajectory. The result refers to the pictures of this object.
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
