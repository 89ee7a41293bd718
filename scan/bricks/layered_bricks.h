// LayeredBricks: gives the bricks of a volume to extraction.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "extract/layered_surface.h"
#include "fusion/bricks/brick_volume.h"
#include "fusion/volume/volume_memory.h"
#include "scan/scan_result.h"

namespace scanknit {

class LayeredBricks final : public LayeredField {
 public:
  /// `bricks` outlives it, and gets no more files.
  explicit LayeredBricks(const BrickVolume& bricks) : bricks_(bricks) {
    for (const auto& [x, blocks] : bricks.layers()) layers_.push_back({x, blocks});
  }

  [[nodiscard]] std::span<const BlockLayer> layers() const override { return layers_; }

  [[nodiscard]] Result<FieldView> read(int begin_x, int end_x) override {
    window_.reset();  // only one is in memory
    auto window = bricks_.read(begin_x, end_x);
    if (!window) return window.error();
    window_.emplace(*std::move(window));
    count(end_x);
    return window_->field_view();
  }

  void let_go() override { window_.reset(); }

  /// What was read so far, as if it were in memory as a whole.
  [[nodiscard]] VolumeResult described() const {
    constexpr double kBytesPerMebibyte = 1024.0 * 1024.0;
    VolumeResult all = counted_;
    all.memory_mib = static_cast<double>(memory_.bytes()) / kBytesPerMebibyte;
    return all;
  }

 private:
  /// Counts the layers that are new: they come by x, and some of them again.
  void count(int end_x) {
    for (const VolumeBlock& block : window_->index().blocks()) {
      if (block.origin.x() < counted_to_x_) continue;
      ++counted_.blocks;
      counted_.active_voxels += block.tsdf->onVoxelCount();
      memory_.add(block.origin);
      if (has_own_colours(*block.colour)) memory_.add_colours();
    }
    counted_to_x_ = std::max(counted_to_x_, end_x);
  }

  const BrickVolume& bricks_;
  std::vector<BlockLayer> layers_;
  std::optional<TsdfVolume> window_;
  int counted_to_x_ = std::numeric_limits<int>::min();
  VolumeResult counted_;
  VolumeMemory memory_;
};

}  // namespace scanknit
