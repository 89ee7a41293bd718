// PointGrid: finds the nearest point within a radius.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace scanknit {

/// Sorts points into cubes as large as the radius. The points must outlive it, and be finite.
class PointGrid {
 public:
  PointGrid(std::span<const Eigen::Vector3f> points, float radius);

  [[nodiscard]] float radius() const { return radius_; }

  /// The nearest point within the radius of `p` that `accepts(index)`; of equally near ones the first.
  template <typename Accepts>
  [[nodiscard]] std::optional<std::uint32_t> nearest(const Eigen::Vector3f& p, const Accepts& accepts) const {
    std::optional<std::uint32_t> best;
    float least = radius_ * radius_;
    const std::array<std::int64_t, 3> middle = cube_of(p);
    if (middle[0] < 0) return best;
    for (std::int64_t x = middle[0] - 1; x <= middle[0] + 1; ++x) {
      for (std::int64_t y = middle[1] - 1; y <= middle[1] + 1; ++y) {
        for (std::int64_t z = middle[2] - 1; z <= middle[2] + 1; ++z) {
          for (const std::uint32_t index : in_cube(key_of({x, y, z}))) {
            const float squared = (points_[index] - p).squaredNorm();
            const bool is_nearer = squared < least || (squared == least && best && index < *best);
            if (!is_nearer || !accepts(index)) continue;
            least = squared;
            best = index;
          }
        }
      }
    }
    return best;
  }
  [[nodiscard]] std::optional<std::uint32_t> nearest(const Eigen::Vector3f& p) const {
    return nearest(p, [](std::uint32_t) { return true; });
  }

 private:
  static constexpr std::uint64_t kEmpty = std::numeric_limits<std::uint64_t>::max();
  struct Slot {
    std::uint64_t key = kEmpty;
    std::uint32_t first = 0, count = 0;
  };

  /// The cube's indices, from 1 at the lowest point; all -1 for a point that is farther than the radius from all
  /// points.
  [[nodiscard]] std::array<std::int64_t, 3> cube_of(const Eigen::Vector3f& p) const;
  [[nodiscard]] static std::uint64_t key_of(const std::array<std::int64_t, 3>& cube) {
    return static_cast<std::uint64_t>(cube[0]) << 42 | static_cast<std::uint64_t>(cube[1]) << 21 |
           static_cast<std::uint64_t>(cube[2]);
  }
  [[nodiscard]] std::size_t place_of(std::uint64_t key) const {
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15u) >> shift_);
  }
  [[nodiscard]] std::span<const std::uint32_t> in_cube(std::uint64_t key) const {
    for (std::size_t at = place_of(key);; at = (at + 1) & (slots_.size() - 1)) {
      if (slots_[at].key == key) return std::span(order_).subspan(slots_[at].first, slots_[at].count);
      if (slots_[at].key == kEmpty) return {};
    }
  }

  std::span<const Eigen::Vector3f> points_;
  float radius_;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
  std::array<std::int64_t, 3> cubes_{};
  std::vector<std::uint32_t> order_;
  std::vector<Slot> slots_;
  int shift_ = 63;
};

}  // namespace scanknit
