#include "fusion/turntable/cut_volume.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

namespace scanknit {
namespace {

using Eigen::Vector3d;
using openvdb::Coord;

// So far above the disc its own surface, and its noise, do not reach.
constexpr double kClearVoxels = 2;
constexpr double kClearSigmas = 2;

/// The object's outline in a plane across the axis: distances to its wall, sampled a voxel apart.
class Outline {
 public:
  Outline(const TsdfVolume& volume, const TurntableSpace& space, double height_m)
      : voxel_m_(volume.config().voxel_size_m),
        u_(space.up.unitOrthogonal()),
        v_(space.up.cross(u_)),
        centre_(space.axis.point + height_m * space.up),
        half_(static_cast<int>(std::ceil(space.radius_m / voxel_m_)) + 2),
        side_(2 * half_ + 1),
        inside_m_(static_cast<float>(-volume.config().truncation_voxels * voxel_m_)),
        cells_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_)) {
    read(volume);
    flood();
    for (Cell& cell : cells_) {
      if (cell.is_outside || cell.is_matter()) continue;
      cell.distance_m = inside_m_;  // enclosed
      cell.weight = 1;
    }
  }

  struct Sample {
    bool is_known = false;
    float distance_m = 0;
    ColourCode colour = 0;
  };
  /// On the line through `p` along the axis.
  [[nodiscard]] Sample at(const Vector3d& p) const {
    const double x = u_.dot(p - centre_) / voxel_m_ + half_;
    const double y = v_.dot(p - centre_) / voxel_m_ + half_;
    const int x0 = static_cast<int>(std::floor(x));
    const int y0 = static_cast<int>(std::floor(y));
    if (x0 < 0 || y0 < 0 || x0 + 1 >= side_ || y0 + 1 >= side_) return {};
    const double fx = x - x0;
    const double fy = y - y0;
    Sample sample{true, 0, cell(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))).colour};
    double distance = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const Cell& at = cell(x0 + corner % 2, y0 + corner / 2);
      if (!(at.weight > 0)) return {};
      distance +=
          (corner % 2 == 1 ? fx : 1 - fx) * (corner / 2 == 1 ? fy : 1 - fy) * static_cast<double>(at.distance_m);
    }
    sample.distance_m = static_cast<float>(distance);
    return sample;
  }

  /// Cells of matter, seen or enclosed.
  [[nodiscard]] std::size_t matter() const {
    return static_cast<std::size_t>(
        std::count_if(cells_.begin(), cells_.end(), [](const Cell& cell) { return cell.is_matter(); }));
  }

 private:
  struct Cell {
    float distance_m = 0;
    float weight = 0;  ///< 0: unknown
    ColourCode colour = 0;
    bool is_outside = false;

    [[nodiscard]] bool is_matter() const { return weight > 0 && distance_m < 0; }
  };
  [[nodiscard]] Cell& cell(int x, int y) {
    return cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x)];
  }
  [[nodiscard]] const Cell& cell(int x, int y) const {
    return cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x)];
  }

  void read(const TsdfVolume& volume) {
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) {
        const Vector3d p = centre_ + voxel_m_ * ((x - half_) * u_ + (y - half_) * v_);
        cell(x, y) = interpolate(volume, p / voxel_m_);
      }
    }
  }

  /// Trilinear; unknown where a corner is.
  static Cell interpolate(const TsdfVolume& volume, const Vector3d& at) {
    const Vector3d low(std::floor(at.x()), std::floor(at.y()), std::floor(at.z()));
    const Vector3d part = at - low;
    Cell cell;
    double distance = 0;
    double nearest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double share = 1;
      Coord index;
      for (int axis = 0; axis < 3; ++axis) {
        const int step = corner >> axis & 1;
        share *= step == 1 ? part[axis] : 1 - part[axis];
        index[axis] = static_cast<int>(low[axis]) + step;
      }
      const WeightCode weight = volume.weight().tree().getValue(index);
      if (weight == 0) return {};
      distance += share * static_cast<double>(volume.tsdf().tree().getValue(index));
      if (share > nearest) {
        nearest = share;
        cell.colour = volume.colour().tree().getValue(index);
      }
    }
    cell.distance_m = static_cast<float>(distance);
    cell.weight = 1;
    return cell;
  }

  /// What can be reached from the rim without crossing matter is outside.
  void flood() {
    std::vector<std::pair<int, int>> open;
    const auto enter = [&](int x, int y) {
      if (x < 0 || y < 0 || x >= side_ || y >= side_) return;
      Cell& at = cell(x, y);
      if (at.is_outside || at.is_matter()) return;
      at.is_outside = true;
      open.emplace_back(x, y);
    };
    for (int i = 0; i < side_; ++i) {
      for (const auto& [x, y] : {std::pair(i, 0), std::pair(i, side_ - 1), std::pair(0, i), std::pair(side_ - 1, i)}) {
        enter(x, y);
      }
    }
    while (!open.empty()) {
      const auto [x, y] = open.back();
      open.pop_back();
      enter(x - 1, y);
      enter(x + 1, y);
      enter(x, y - 1);
      enter(x, y + 1);
    }
  }

  double voxel_m_;
  Vector3d u_, v_, centre_;
  int half_, side_;
  float inside_m_;
  std::vector<Cell> cells_;
};

/// Adds the blocks between two heights that the volume does not have.
void add_slab(const TurntableSpace& space, double low_m, double high_m, TsdfVolume& volume) {
  const double block_m = kBlockEdgeVoxels * volume.config().voxel_size_m;
  const Vector3d centre = space.axis.point + (low_m + high_m) / 2 * space.up;
  const double reach_m = space.radius_m + high_m - low_m + 2 * block_m;
  const auto first = [&](int axis) { return static_cast<int>(std::floor((centre[axis] - reach_m) / block_m)); };
  const auto last = [&](int axis) { return static_cast<int>(std::ceil((centre[axis] + reach_m) / block_m)); };
  for (int i = first(0); i <= last(0); ++i) {
    for (int j = first(1); j <= last(1); ++j) {
      for (int k = first(2); k <= last(2); ++k) {
        const Vector3d middle = (Vector3d(i, j, k) + Vector3d::Constant(0.5)) * block_m;
        const double height = space.height_of(middle);
        if (height < low_m - block_m || height > high_m + block_m) continue;
        if (space.distance_of(middle) > space.radius_m + block_m) continue;
        const Coord origin(kBlockEdgeVoxels * i, kBlockEdgeVoxels * j, kBlockEdgeVoxels * k);
        if (volume.index().find(origin) != BlockIndex::kNone) continue;
        volume.add_block(NewBlock(origin, volume.tsdf().background()));
      }
    }
  }
}

void forget(const VolumeBlock& block, openvdb::Index offset, float background) {
  block.tsdf->setValueOff(offset, background);
  block.weight->setValueOff(offset, WeightCode{0});
  block.colour->setValueOff(offset, ColourCode{0});
}

void set(const VolumeBlock& block, openvdb::Index offset, float distance_m, ColourCode colour) {
  block.tsdf->setValueOn(offset, distance_m);
  block.weight->setValueOn(offset, encode_weight(1.0f));
  if (has_colour(colour)) block.colour->allocate();
  block.colour->setValueOn(offset, colour);
}

/// The height above which the disc, if it was seen, does not disturb.
double clear_height_m(const TurntableSpace& space, const FusionConfig& config) {
  const double sigma_m = config.noise.sigma_m(space.axis.point.norm());
  return space.disc_m.value_or(0) + std::max(kClearVoxels * config.voxel_size_m, kClearSigmas * sigma_m);
}

}  // namespace

bool is_kept(const TurntableSpace& space, const FusionConfig& config, const Vector3d& p) {
  const bool is_low = space.disc_m && space.height_of(p) < clear_height_m(space, config);
  return !is_low && space.distance_of(p) <= space.radius_m;
}

VolumeCut cut_volume(const TurntableSpace& space, bool closes_base, TsdfVolume& volume) {
  const double voxel_m = volume.config().voxel_size_m;
  const auto truncation_m = static_cast<float>(volume.config().truncation_voxels * voxel_m);
  const double disc_m = space.disc_m.value_or(0);
  const double clear_m = clear_height_m(space, volume.config());
  const double below_m = disc_m - 3 * voxel_m;
  VolumeCut cut;
  std::unique_ptr<Outline> outline;
  if (space.disc_m && closes_base) {
    outline = std::make_unique<Outline>(volume, space, clear_m);
    cut.base_m2 = static_cast<double>(outline->matter()) * voxel_m * voxel_m;
    cut.has_base = outline->matter() > 0;
    if (cut.has_base) add_slab(space, below_m, clear_m, volume);
  }
  const auto blocks = volume.index().blocks();
  const float background = volume.tsdf().background();
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
    VolumeBlock& block = blocks[i];
    const bool had_colours = has_own_colours(*block.colour);
    block.has_changed = true;
    for (openvdb::Index offset = 0; offset < TsdfLeaf::SIZE; ++offset) {
      const Coord index = block.tsdf->offsetToGlobalCoord(offset);
      const Vector3d p = voxel_m * Vector3d(index.x(), index.y(), index.z());
      const double height = space.height_of(p);
      const bool is_low = space.disc_m && height < clear_m;
      if (!is_low && space.distance_of(p) <= space.radius_m) continue;
      const auto wall = is_low && cut.has_base && height >= below_m ? outline->at(p) : Outline::Sample{};
      if (!wall.is_known) {
        forget(block, offset, background);
        continue;
      }
      const auto above_disc = static_cast<float>(height - disc_m);  // matter is above the disc and within the wall
      set(block, offset, std::clamp(std::max(wall.distance_m, -above_disc), -truncation_m, truncation_m), wall.colour);
    }
    block.is_free = false;
    block.has_matter = true;
    if (!had_colours && has_own_colours(*block.colour)) volume.count_colours_of_a_block();
  });
  return cut;
}

}  // namespace scanknit
