#include "extract/block_topology.h"

#include <bit>
#include <cmath>
#include <limits>

namespace scanknit {

float float_isovalue(double isovalue) {
  if (isovalue > static_cast<double>(std::numeric_limits<float>::max())) return std::numeric_limits<float>::infinity();
  if (isovalue < static_cast<double>(std::numeric_limits<float>::lowest())) return std::numeric_limits<float>::lowest();
  const auto nearest = static_cast<float>(isovalue);
  return static_cast<double>(nearest) >= isovalue ? nearest
                                                  : std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

BlockTopology::BlockTopology(const ValueBlock& values, float isovalue) {
  classify_samples(values, isovalue);
  classify_cells();
  find_vertices();
}

void BlockTopology::classify_samples(const ValueBlock& values, float isovalue) {
  for (int x = -1; x < kRows - 1; ++x) {
    for (int y = -1; y < kRows - 1; ++y) {
      const auto samples = values.row(x, y);
      unsigned high = 0;
      unsigned observed = 0;
      for (unsigned i = 0; i < kRows; ++i) {
        high |= static_cast<unsigned>(samples[i] >= isovalue) << i;  // false for kUnobserved
        observed |= static_cast<unsigned>(is_observed(samples[i])) << i;
      }
      high_[static_cast<std::size_t>(x + 1)][static_cast<std::size_t>(y + 1)] = static_cast<RowBits>(high);
      observed_[static_cast<std::size_t>(x + 1)][static_cast<std::size_t>(y + 1)] = static_cast<RowBits>(observed);
    }
  }
}

void BlockTopology::classify_cells() {
  for (int x = -1; x < kBlockCells; ++x) {
    for (int y = -1; y < kBlockCells; ++y) {
      unsigned all_observed = ~0u;
      unsigned any_high = 0;
      unsigned any_low = 0;
      for (const int dx : {0, 1}) {
        for (const int dy : {0, 1}) {
          const unsigned observed = row(observed_, x + dx, y + dy);
          const unsigned high = row(high_, x + dx, y + dy);
          all_observed &= observed;
          any_high |= high;
          any_low |= observed & ~high;
        }
      }
      const unsigned valid = all_observed & (all_observed >> 1);
      const unsigned mixed = (any_high | (any_high >> 1)) & (any_low | (any_low >> 1));
      valid_[static_cast<std::size_t>(x + 1)][static_cast<std::size_t>(y + 1)] = static_cast<RowBits>(valid);
      if (x < 0 || y < 0) continue;
      const auto own = [](unsigned bits) { return std::uint64_t{(bits >> 1) & 0xFFu}; };  // z from 0 to 7
      active_cells_[static_cast<std::size_t>(x)] |= own(valid & mixed) << (kBlockCells * y);
      cells_without_surface_ += static_cast<std::size_t>(std::popcount(own(valid & ~mixed)));
      skipped_cells_ += static_cast<std::size_t>(std::popcount(own(mixed & ~valid)));
    }
  }
}

void BlockTopology::find_vertices() {
  for (int x = 0; x < kBlockCells; ++x) {
    for (int y = 0; y < kBlockCells; ++y) {
      // The cells round an edge: at the edge's own voxel, one back along the first and second other axis, and both.
      const unsigned here = row(valid_, x, y);
      const unsigned back_x = row(valid_, x - 1, y);
      const unsigned back_y = row(valid_, x, y - 1);
      const unsigned back_xy = row(valid_, x - 1, y - 1);
      const unsigned high = row(high_, x, y);
      add_vertices(0, x, y, high ^ row(high_, x + 1, y), {here, back_y, here << 1, back_y << 1});
      add_vertices(1, x, y, high ^ row(high_, x, y + 1), {here, back_x, here << 1, back_x << 1});
      add_vertices(2, x, y, high ^ (high >> 1), {here, back_x, back_y, back_xy});
    }
  }
}

void BlockTopology::add_vertices(int axis, int x, int y, unsigned crossed,
                                 const std::array<unsigned, 4>& valid_around) {
  const auto [a, b, c, d] = valid_around;
  const unsigned used = a | b | c | d;
  const unsigned pinched = (a & d & ~b & ~c) | (b & c & ~a & ~d);
  const auto word = [&](unsigned bits) { return std::uint64_t{((crossed & bits) >> 1) & 0xFFu} << (kBlockCells * y); };
  vertices_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(x)] |= word(used);
  pinched_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(x)] |= word(pinched);
}

CornerMask BlockTopology::highs(int x, int y, int z) const {
  unsigned mask = 0;
  for (int corner = 0; corner < kCorners; ++corner) {
    const unsigned bits = row(high_, x + corner_coordinate(corner, 0), y + corner_coordinate(corner, 1));
    mask |= ((bits >> (z + 1 + corner_coordinate(corner, 2))) & 1u) << corner;
  }
  return static_cast<CornerMask>(mask);
}

}  // namespace scanknit
