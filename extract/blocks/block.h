// Blocks of 8 x 8 x 8 samples: their signs, their values with a margin, and BlockSource, which provides them.
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

inline constexpr int kBlockCells = 8;  ///< cells along each axis; also the samples that a block owns
/// The range of a ValueBlock's samples. It is larger than the block, for gradients and for cells of neighbouring
/// blocks.
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

/// The signs of a block's 512 samples: all that the topology depends on.
struct BlockSigns {
  VoxelBits high{};     ///< observed and >= isovalue
  VoxelBits missing{};  ///< unobserved

  bool operator==(const BlockSigns&) const = default;
};

/// Samples at (x, y, z), each from -1 to 9 relative to the block's origin. Either refers to the source's memory, or to
/// a copy in its own buffer.
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

  /// Copies the samples to the buffer: all, or only those from 0 to 8, which the block's own cells use. Useful if most
  /// samples are read more than once: rows of a large array are far apart in memory, often at multiples of a power of
  /// two, so that they would evict one another from the cache.
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

  /// Refers to the buffer, whose samples must then be written through row().
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

/// The colours of a ValueBlock's samples: sRGB-encoded, 0 to 1; no_colour() if no colour was seen.
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

/// A volume as blocks. Samples outside of the listed blocks are unobserved. Several threads may call it at once.
class BlockSource {
 public:
  virtual ~BlockSource() = default;

  /// Index coordinates of each block's first voxel, multiples of 8, sorted by is_before.
  [[nodiscard]] virtual std::span<const Eigen::Vector3i> origins() const = 0;
  /// Computes the signs of the blocks from `first` on, one for each element of `signs`. `isovalue`: from
  /// float_isovalue().
  virtual void classify(std::size_t first, float isovalue, std::span<BlockSigns> signs) const = 0;
  virtual void load_values(std::size_t block, ValueBlock& values) const = 0;
  [[nodiscard]] virtual bool has_colours() const { return false; }
  /// May be called only if has_colours().
  virtual void load_colours(std::size_t /*block*/, ColourBlock& /*colours*/) const {}

  /// From index coordinates to the world, metres for a scan; invertible. May be anisotropic, turned and mirrored.
  [[nodiscard]] virtual const Eigen::Affine3d& T_world_index() const = 0;
};

/// True if floats at the distance `reach` from the world's origin are fine enough for grid edges of `shortest_edge`: an
/// edge then has at least 8 to 16 steps, so that vertices stay apart and triangles keep an area.
[[nodiscard]] inline bool can_floats_resolve(double shortest_edge, double reach) {
  constexpr double kSteps = 8;
  return shortest_edge >= kSteps * reach * static_cast<double>(std::numeric_limits<float>::epsilon());
}
inline constexpr const char* kTooFarForFloats =
    "it lies too far from the world's origin for 32-bit positions of its samples' spacing; move its origin nearer";

/// True if the index coordinates are left-handed in the world.
[[nodiscard]] inline bool is_mirrored(const BlockSource& source) {
  return source.T_world_index().linear().determinant() < 0;
}

}  // namespace scanknit
