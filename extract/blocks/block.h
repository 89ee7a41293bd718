// Blocks of 8 x 8 x 8 samples: their signs, the values around them, and BlockSource: where blocks come from.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

namespace scanknit {

inline constexpr int kBlockCells = 8;  ///< along each axis; also samples that a block owns
/// Samples round a block that a ValueBlock shows: for gradients and for the cells of neighbouring blocks.
inline constexpr int kBlockFirst = -1;
inline constexpr int kBlockLast = 9;
inline constexpr int kValueBlockSide = kBlockLast - kBlockFirst + 1;  ///< 11 samples along each axis
inline constexpr std::size_t kValueBlockSamples = std::size_t{kValueBlockSide} * kValueBlockSide * kValueBlockSide;

/// In the volume's unit. Samples that are not finite are unobserved.
inline constexpr float kUnobserved = std::numeric_limits<float>::quiet_NaN();
[[nodiscard]] inline bool is_observed(float value) {
  return std::isfinite(value);
}

/// One bit for each voxel (or cell, or grid edge) of a block: word x, bit 8 y + z.
using VoxelBits = std::array<std::uint64_t, kBlockCells>;

/// What topology needs of a block's 512 samples.
struct BlockSigns {
  VoxelBits high{};     ///< observed and >= isovalue
  VoxelBits missing{};  ///< unobserved

  bool operator==(const BlockSigns&) const = default;
};

/// Samples at (x, y, z), each from -1 to 9 relative to the block's origin. Either a window on the source's own memory,
/// or a copy in the buffer that each ValueBlock carries.
class ValueBlock {
 public:
  ValueBlock() = default;
  ValueBlock(const ValueBlock&) = delete;
  ValueBlock& operator=(const ValueBlock&) = delete;

  [[nodiscard]] float at(int x, int y, int z) const { return origin_[x * stride_x_ + y * stride_y_ + z]; }
  [[nodiscard]] float at(const Eigen::Vector3i& p) const { return at(p.x(), p.y(), p.z()); }

  /// `origin` points at sample (0, 0, 0); rows along z are contiguous. The memory must outlive the block.
  void show(const float* origin, std::ptrdiff_t stride_x, std::ptrdiff_t stride_y) {
    origin_ = origin;
    stride_x_ = stride_x;
    stride_y_ = stride_y;
  }

  /// Copies what is shown to the buffer: all, or only the samples from 0 to 8, those of the block's own cells. Worth it
  /// where most samples are read more than once: rows of a large array lie far apart in memory, often at the same
  /// distance modulo a power of two, and would drive one another from the cache.
  void keep(bool only_own_cells) {
    if (origin_ == buffer_origin()) return;
    const int first = only_own_cells ? 0 : kBlockFirst;
    const int last = only_own_cells ? kBlockCells : kBlockLast;
    for (int x = first; x <= last; ++x) {
      for (int y = first; y <= last; ++y)
        std::memcpy(row(x, y).data(), origin_ + x * stride_x_ + y * stride_y_ + kBlockFirst,
                    kValueBlockSide * sizeof(float));
    }
    show_buffer();
  }

  /// Shows the buffer, whose samples are to be written through row().
  void show_buffer() { show(buffer_origin(), kValueBlockSide * kValueBlockSide, kValueBlockSide); }

  /// The samples (x, y, -1) to (x, y, 9) of the buffer.
  [[nodiscard]] std::span<float, kValueBlockSide> row(int x, int y) {
    return std::span<float, kValueBlockSide>(buffer_.data() + row_start(x, y), kValueBlockSide);
  }

 private:
  [[nodiscard]] static std::size_t row_start(int x, int y) {
    return static_cast<std::size_t>(((x - kBlockFirst) * kValueBlockSide + (y - kBlockFirst)) * kValueBlockSide);
  }
  [[nodiscard]] const float* buffer_origin() const { return buffer_.data() + row_start(0, 0) - kBlockFirst; }

  const float* origin_ = nullptr;
  std::ptrdiff_t stride_x_ = 0;
  std::ptrdiff_t stride_y_ = 0;
  std::array<float, kValueBlockSamples> buffer_;  // not initialised: most blocks never need it
};

/// sRGB-encoded, 0 to 1; no_colour() where none was seen. The same samples as a ValueBlock.
class ColourBlock {
 public:
  [[nodiscard]] const Eigen::Vector3f& at(const Eigen::Vector3i& p) const {
    return samples_[row_start(p.x(), p.y()) + static_cast<std::size_t>(p.z() - kBlockFirst)];
  }
  [[nodiscard]] std::span<Eigen::Vector3f, kValueBlockSide> row(int x, int y) {
    return std::span<Eigen::Vector3f, kValueBlockSide>(samples_.data() + row_start(x, y), kValueBlockSide);
  }
  [[nodiscard]] static bool contains(const Eigen::Vector3i& p) {
    return p.minCoeff() >= kBlockFirst && p.maxCoeff() <= kBlockLast;
  }

 private:
  [[nodiscard]] static std::size_t row_start(int x, int y) {
    return static_cast<std::size_t>(((x - kBlockFirst) * kValueBlockSide + (y - kBlockFirst)) * kValueBlockSide);
  }
  std::array<Eigen::Vector3f, kValueBlockSamples> samples_;
};

[[nodiscard]] inline Eigen::Vector3f no_colour() {
  return Eigen::Vector3f::Constant(-1);
}
[[nodiscard]] inline bool has_colour(const Eigen::Vector3f& colour) {
  return colour.x() >= 0;
}

/// The order of blocks: lexicographic.
[[nodiscard]] inline bool is_before(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  if (a.x() != b.x()) return a.x() < b.x();
  return a.y() != b.y() ? a.y() < b.y() : a.z() < b.z();
}

/// A volume as blocks. Observed samples lie in blocks of the list only. Calls from several threads are safe.
class BlockSource {
 public:
  virtual ~BlockSource() = default;

  /// Index coordinates of each block's first voxel, multiples of 8, sorted by is_before.
  [[nodiscard]] virtual std::span<const Eigen::Vector3i> origins() const = 0;
  /// Signs of the blocks from `first` on, one for each element of `signs`. `isovalue` as of float_isovalue().
  virtual void classify(std::size_t first, float isovalue, std::span<BlockSigns> signs) const = 0;
  virtual void load_values(std::size_t block, ValueBlock& values) const = 0;
  [[nodiscard]] virtual bool has_colours() const { return false; }
  /// Only where has_colours().
  virtual void load_colours(std::size_t /*block*/, ColourBlock& /*colours*/) const {}

  /// From index coordinates to the world, metres for a scan; invertible. May be anisotropic, turned and mirrored.
  [[nodiscard]] virtual const Eigen::Affine3d& T_world_index() const = 0;
};

/// Whether floats at `reach` from the world's origin are fine enough for a mesh with grid edges of `shortest_edge`: 8
/// to 16 steps each, so that vertices keep apart and triangles keep an area.
[[nodiscard]] inline bool can_floats_resolve(double shortest_edge, double reach) {
  constexpr double kSteps = 8;
  return shortest_edge >= kSteps * reach * static_cast<double>(std::numeric_limits<float>::epsilon());
}
inline constexpr const char* kTooFarForFloats =
    "it lies too far from the world's origin for 32-bit positions of its samples' spacing; move its origin nearer";

/// Its index coordinates are left-handed in the world.
[[nodiscard]] inline bool is_mirrored(const BlockSource& source) {
  return source.T_world_index().linear().determinant() < 0;
}

}  // namespace scanknit
