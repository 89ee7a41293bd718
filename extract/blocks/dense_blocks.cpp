#include "extract/blocks/dense_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "extract/blocks/sign_bytes.h"

namespace scanknit {
namespace {

int blocks_along(int samples) {
  return (samples + kBlockCells - 1) / kBlockCells;
}

/// Blocks count (k, j, i) where the array counts (i, j, k).
Eigen::Affine3d with_axes_reversed(const Eigen::Affine3d& T_world_ijk) {
  Eigen::Affine3d T_world_index = T_world_ijk;
  T_world_index.linear() = T_world_ijk.linear().rowwise().reverse();
  return T_world_index;
}

Error config_error(const char* message) {
  return {ErrorCode::kConfig, message, "volume"};
}

}  // namespace

DenseBlocks::DenseBlocks(const DenseView& view, int first_k)
    : view_(view), first_k_(first_k), T_world_index_(with_axes_reversed(view.T_world_ijk)) {
  const Eigen::Vector3i blocks = view.dims.unaryExpr(&blocks_along);
  blocks_per_layer_ = static_cast<std::size_t>(blocks.y()) * static_cast<std::size_t>(blocks.x());
  origins_.reserve(blocks_per_layer_ * static_cast<std::size_t>(blocks.z()));
  for (int x = 0; x < blocks.z(); ++x) {
    for (int y = 0; y < blocks.y(); ++y) {
      for (int z = 0; z < blocks.x(); ++z)
        origins_.emplace_back(first_k + kBlockCells * x, kBlockCells * y, kBlockCells * z);
    }
  }
}

Result<DenseBlocks> DenseBlocks::open(const DenseView& view, int first_k) {
  constexpr int kMaxSamples = std::numeric_limits<int>::max() - 4 * kBlockCells;
  if (view.dims.minCoeff() < 1 || view.dims.maxCoeff() > kMaxSamples - first_k)
    return config_error("each of its dimensions must be from 1 to 2^31 - 32");
  const Eigen::Affine3d& T = view.T_world_ijk;
  const Eigen::Vector3d far = view.dims.cast<double>() + Eigen::Vector3d(0, 0, first_k);
  const double reach = (T.linear().cwiseAbs() * far + T.translation().cwiseAbs()).maxCoeff();
  const double shortest = T.linear().colwise().norm().minCoeff();
  if (!T.matrix().allFinite() || !(std::abs(T.linear().determinant()) > 0) ||
      !(shortest >= std::numeric_limits<float>::min()) || !(reach <= std::numeric_limits<float>::max()))
    return config_error("its spacing, origin or directions cannot be used: check them in its header");
  if (!can_floats_resolve(shortest, reach)) return config_error(kTooFarForFloats);
  return DenseBlocks(view, first_k);
}

void DenseBlocks::classify(std::size_t first, float isovalue, std::span<BlockSigns> signs) const {
  for (std::size_t done = 0; done < signs.size();) {
    // Blocks that differ in z only are classified together, row by row of the array.
    const Eigen::Vector3i origin = origins_[first + done];
    const auto in_row = static_cast<std::size_t>(blocks_along(view_.dims.x()) - origin.z() / kBlockCells);
    const auto run = signs.subspan(done, std::min(signs.size() - done, in_row));
    classify_run(origin, isovalue, run);
    done += run.size();
  }
}

void DenseBlocks::classify_run(const Eigen::Vector3i& origin, float isovalue, std::span<BlockSigns> signs) const {
  const auto inside = static_cast<std::size_t>(view_.dims.x() - origin.z());
  const std::size_t whole = std::min(signs.size(), inside / kBlockCells);  // blocks with eight samples a row
  std::array<std::vector<std::uint8_t>, kBlockCells> high;                 // by y
  std::array<std::vector<std::uint8_t>, kBlockCells> missing;
  high.fill(std::vector<std::uint8_t>(signs.size()));
  missing.fill(std::vector<std::uint8_t>(signs.size()));
  for (int x = 0; x < kBlockCells; ++x) {
    for (int y = 0; y < kBlockCells; ++y) {
      auto& row_high = high[static_cast<std::size_t>(y)];
      auto& row_missing = missing[static_cast<std::size_t>(y)];
      if (!contains(origin.x() + x, origin.y() + y)) {
        row_high.assign(signs.size(), 0);
        row_missing.assign(signs.size(), 0xFF);
        continue;
      }
      const float* const row = sample(origin.x() + x, origin.y() + y, origin.z());
      sign_bytes(row, whole, isovalue, row_high.data(), row_missing.data());
      if (whole == signs.size()) continue;
      std::array<float, kBlockCells> last;
      last.fill(kUnobserved);
      std::copy(row + kBlockCells * whole, row + inside, last.begin());
      sign_bytes(last.data(), 1, isovalue, &row_high[whole], &row_missing[whole]);
    }
    for (std::size_t block = 0; block < signs.size(); ++block) {
      std::uint64_t is_high = 0;
      std::uint64_t is_missing = 0;
      for (std::size_t y = 0; y < kBlockCells; ++y) {
        is_high |= std::uint64_t{high[y][block]} << (kBlockCells * y);
        is_missing |= std::uint64_t{missing[y][block]} << (kBlockCells * y);
      }
      signs[block].high[static_cast<std::size_t>(x)] = is_high;
      signs[block].missing[static_cast<std::size_t>(x)] = is_missing;
    }
  }
}

void DenseBlocks::load_values(std::size_t block, ValueBlock& values) const {
  const Eigen::Vector3i& origin = origins_[block];
  const Eigen::Vector3i low = origin + Eigen::Vector3i::Constant(kBlockFirst);
  const Eigen::Vector3i high = origin + Eigen::Vector3i::Constant(kBlockLast);
  if (contains(low.x(), low.y()) && contains(high.x(), high.y()) && low.z() >= 0 && high.z() < view_.dims.x()) {
    const std::ptrdiff_t row = view_.dims.x();
    return values.show(sample(origin.x(), origin.y(), origin.z()), row * view_.dims.y(), row);
  }
  const int first = std::max(low.z(), 0);
  const int last = std::min(high.z(), view_.dims.x() - 1);
  for (int x = kBlockFirst; x <= kBlockLast; ++x) {
    for (int y = kBlockFirst; y <= kBlockLast; ++y) {
      const auto to = values.row(x, y);
      std::fill(to.begin(), to.end(), kUnobserved);
      if (!contains(origin.x() + x, origin.y() + y)) continue;
      const float* const from = sample(origin.x() + x, origin.y() + y, first);
      std::copy(from, from + (last - first + 1), to.begin() + (first - low.z()));
    }
  }
  values.show_buffer();
}

}  // namespace scanknit
