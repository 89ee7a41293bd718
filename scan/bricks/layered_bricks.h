// LayeredBricks: gives the bricks of a volume to extraction.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "extract/layered_surface.h"
#include "fusion/bricks/brick_volume.h"

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
    return window_->field_view();
  }

 private:
  const BrickVolume& bricks_;
  std::vector<BlockLayer> layers_;
  std::optional<TsdfVolume> window_;
};

}  // namespace scanknit
