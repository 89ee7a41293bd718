// Block: the samples that 8 x 8 x 8 cells need, and BlockSource: where blocks come from.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace scanknit {

/// Samples of one kind at (x, y, z), each from -1 to 9 relative to the block's origin. The block's 512 cells need the
/// 9^3 samples from 0 to 8; the layer around them serves gradients and the cells of neighbouring blocks at a shared
/// grid edge.
template <typename Sample>
class BlockOf {
 public:
  static constexpr int kFirst = -1;
  static constexpr int kLast = 9;
  static constexpr int kSide = kLast - kFirst + 1;

  [[nodiscard]] const Sample& at(int x, int y, int z) const { return samples_[index(x, y, z)]; }
  [[nodiscard]] const Sample& at(const Eigen::Vector3i& p) const { return at(p.x(), p.y(), p.z()); }
  /// The samples (x, y, z) to (x, y, kLast), contiguous.
  [[nodiscard]] std::span<const Sample> row(int x, int y, int z = kFirst) const {
    return std::span(samples_).subspan(index(x, y, z), static_cast<std::size_t>(kLast - z + 1));
  }
  [[nodiscard]] std::span<Sample> row(int x, int y, int z = kFirst) {
    return std::span(samples_).subspan(index(x, y, z), static_cast<std::size_t>(kLast - z + 1));
  }

  [[nodiscard]] static bool contains(const Eigen::Vector3i& p) {
    return p.minCoeff() >= kFirst && p.maxCoeff() <= kLast;
  }

 private:
  [[nodiscard]] static std::size_t index(int x, int y, int z) {
    return static_cast<std::size_t>(((x - kFirst) * kSide + (y - kFirst)) * kSide + (z - kFirst));
  }
  std::array<Sample, static_cast<std::size_t>(kSide* kSide* kSide)> samples_;
};

inline constexpr int kBlockCells = 8;  ///< along each axis

/// Values in the volume's unit; kUnobserved where nothing is known. Never infinite.
using ValueBlock = BlockOf<float>;
inline constexpr float kUnobserved = std::numeric_limits<float>::quiet_NaN();
[[nodiscard]] inline bool is_observed(float value) {
  return !std::isnan(value);
}

/// sRGB-encoded, 0 to 1; no_colour() where none was seen.
using ColourBlock = BlockOf<Eigen::Vector3f>;
[[nodiscard]] inline Eigen::Vector3f no_colour() {
  return Eigen::Vector3f::Constant(-1);
}
[[nodiscard]] inline bool has_colour(const Eigen::Vector3f& colour) {
  return colour.x() >= 0;
}

/// The order of blocks: lexicographic.
[[nodiscard]] inline bool is_before(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

/// A volume as blocks. Its samples lie at world points voxel_size_m * index + translation_m. Observed samples lie in
/// blocks of the list only. Calls from several threads are safe.
class BlockSource {
 public:
  virtual ~BlockSource() = default;

  /// Index coordinates of each block's first voxel, multiples of 8, sorted by is_before.
  [[nodiscard]] virtual std::span<const Eigen::Vector3i> origins() const = 0;
  virtual void load_values(std::size_t block, ValueBlock& values) const = 0;
  [[nodiscard]] virtual bool has_colours() const = 0;
  /// Only where has_colours().
  virtual void load_colours(std::size_t block, ColourBlock& colours) const = 0;

  [[nodiscard]] virtual double voxel_size_m() const = 0;
  [[nodiscard]] virtual Eigen::Vector3d translation_m() const = 0;
};

}  // namespace scanknit
