#include "finish/smallest_surface.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "finish/voxel_set.h"

namespace scanknit {
namespace {

using Dual = std::array<float, 3>;

// sigma tau 12 <= 1, 12 being the bound on the squared norm of the gradient in three dimensions (Chambolle 2004).
constexpr float kStep = 0.28867513f;
constexpr int kFirstSteps = 500;     // iterations at the coarsest level, which is small
constexpr int kSteps = 80;           // iterations at each finer level, which starts with the coarser result
constexpr int kCoarsestSide = 20;    // no level is coarser than this
constexpr int kChangeableCells = 2;  // voxels within this distance of the coarse surface may still change sides
constexpr int kSmoothSteps = 14;

template <typename Work>
void for_all(std::size_t count, const Work& work) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) work(i);
  });
}

struct Level {
  VoxelBox box;
  std::vector<VoxelLabel> own_labels;  ///< of coarser levels
  std::span<const VoxelLabel> labels;
  std::vector<float> matter;  ///< u of the paper, from 0 (free) to 1 (matter)
  VoxelSet open;              ///< voxels whose label is still to be found
  VoxelSet kept;              ///< voxels whose dual is kept: all, or in the finest level those whose dual changes
  std::vector<Dual> dual;     ///< p, by the voxel's number in `kept`
};

VoxelBox half(const VoxelBox& fine) {
  VoxelBox coarse;
  coarse.dims = (fine.dims.array() + 1) / 2;
  return coarse;
}

/// The next coarser level. A coarse voxel is known if its known voxels agree.
Level coarser(const Level& fine) {
  Level coarse;
  coarse.box = half(fine.box);
  coarse.own_labels.resize(coarse.box.voxels());
  for_all(coarse.own_labels.size(), [&](std::size_t i) {
    const Eigen::Vector3i at = 2 * coarse.box.place(i);
    bool has_matter = false;
    bool has_free = false;
    for (int corner = 0; corner < 8; ++corner) {
      const int x = at.x() + (corner & 1);
      const int y = at.y() + (corner >> 1 & 1);
      const int z = at.z() + (corner >> 2);
      if (!fine.box.contains(x, y, z)) continue;
      const VoxelLabel label = fine.labels[fine.box.at(x, y, z)];
      has_matter |= label == VoxelLabel::kMatter;
      has_free |= label == VoxelLabel::kFree;
    }
    coarse.own_labels[i] = has_matter == has_free ? VoxelLabel::kUnknown
                           : has_matter           ? VoxelLabel::kMatter
                                                  : VoxelLabel::kFree;
  });
  coarse.labels = coarse.own_labels;
  return coarse;
}

float start_of(VoxelLabel label) {
  return label == VoxelLabel::kMatter ? 1.0f : label == VoxelLabel::kFree ? 0.0f : 0.5f;
}

/// For each coarse voxel: 1 if the surface is within kChangeableCells of it along every axis.
std::vector<std::uint8_t> near_surface(const Level& level) {
  std::vector<std::uint8_t> near(level.box.voxels());
  for_all(near.size(), [&](std::size_t i) {
    const float here = level.matter[i];
    const Eigen::Vector3i at = level.box.place(i);
    bool is_near = here > 0.05f && here < 0.95f;
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t step = level.box.stride(axis);
      if (at[axis] > 0) is_near |= (level.matter[i - step] >= 0.5f) != (here >= 0.5f);
      if (at[axis] + 1 < level.box.dims[axis]) is_near |= (level.matter[i + step] >= 0.5f) != (here >= 0.5f);
    }
    near[i] = is_near ? 1 : 0;
  });
  std::vector<std::uint8_t> wider(near.size());
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t step = level.box.stride(axis);
    for_all(near.size(), [&](std::size_t i) {
      const int at = level.box.place(i)[axis];
      bool is_near = false;
      for (int away = -kChangeableCells; away <= kChangeableCells; ++away) {
        if (at + away < 0 || at + away >= level.box.dims[axis]) continue;
        const std::size_t far = step * static_cast<std::size_t>(std::abs(away));
        is_near |= near[away < 0 ? i - far : i + far] != 0;
      }
      wider[i] = is_near ? 1 : 0;
    });
    near.swap(wider);
  }
  return near;
}

/// The coarser level's voxel that holds voxel `i`.
std::size_t parent_of(const Level& fine, std::size_t i, const Level& coarse) {
  const Eigen::Vector3i at = fine.box.place(i) / 2;
  return coarse.box.at(at.x(), at.y(), at.z());
}

/// The voxels whose dual changes: the open voxels, and the ones before them along an axis.
VoxelSet changing_dual(const Level& level) {
  return VoxelSet::where(level.box.voxels(), [&](std::size_t i) {
    if (level.open.contains(i)) return true;
    const Eigen::Vector3i at = level.box.place(i);
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] + 1 < level.box.dims[axis] && level.open.contains(i + level.box.stride(axis))) return true;
    }
    return false;
  });
}

VoxelSet all_of(const VoxelBox& box) {
  return VoxelSet::where(box.voxels(), [](std::size_t) { return true; });
}

/// Finds out what is still open in a level below `coarse`. With `fixes_far_voxels`, voxels far from the surface keep
/// the coarser level's result.
void find_open(const Level& coarse, bool fixes_far_voxels, Level& fine) {
  const std::vector<std::uint8_t> near = fixes_far_voxels ? near_surface(coarse) : std::vector<std::uint8_t>();
  fine.open = VoxelSet::where(fine.box.voxels(), [&](std::size_t i) {
    return fine.labels[i] == VoxelLabel::kUnknown && (!fixes_far_voxels || near[parent_of(fine, i, coarse)] != 0);
  });
}

/// Starts a level, whose open voxels are known, from the coarser one's result.
void begin_from(const Level& coarse, Level& fine) {
  fine.matter.resize(fine.box.voxels());
  for_all(fine.matter.size(), [&](std::size_t i) {
    const float from = coarse.matter[parent_of(fine, i, coarse)];
    const bool is_unknown = fine.labels[i] == VoxelLabel::kUnknown;
    fine.matter[i] = !is_unknown ? start_of(fine.labels[i]) : fine.open.contains(i) ? from : std::round(from);
  });
  fine.dual.resize(fine.kept.size());
  fine.kept.for_each([&](std::size_t i, std::size_t n) { fine.dual[n] = coarse.dual[parent_of(fine, i, coarse)]; });
}

void begin_coarsest(Level& level) {
  level.matter.resize(level.box.voxels());
  for (std::size_t i = 0; i < level.matter.size(); ++i) level.matter[i] = start_of(level.labels[i]);
  level.open =
      VoxelSet::where(level.matter.size(), [&](std::size_t i) { return level.labels[i] == VoxelLabel::kUnknown; });
  level.kept = all_of(level.box);
  level.dual.assign(level.kept.size(), {0, 0, 0});
}

/// Chambolle & Pock 2011, algorithm 1, for the total variation of u with u between 0 and 1 and given where known.
void solve(Level& level, int steps) {
  const VoxelBox& box = level.box;
  const VoxelSet changing = changing_dual(level);
  std::vector<float> matter(level.open.size());
  level.open.for_each([&](std::size_t i, std::size_t n) { matter[n] = level.matter[i]; });
  std::vector<float>& ahead = level.matter;  // u-bar
  const std::array<std::size_t, 3> stride = {box.stride(0), box.stride(1), box.stride(2)};
  for (int step = 0; step < steps; ++step) {
    changing.for_each([&](std::size_t i, std::size_t) {
      const Eigen::Vector3i at = box.place(i);
      Dual& dual = level.dual[level.kept.number(i)];
      Dual p = dual;
      float squared = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool is_last = at[static_cast<int>(axis)] + 1 >= box.dims[static_cast<int>(axis)];
        p[axis] = is_last ? 0 : p[axis] + kStep * (ahead[i + stride[axis]] - ahead[i]);
        squared += p[axis] * p[axis];
      }
      const float scale = squared > 1 ? 1 / std::sqrt(squared) : 1.0f;
      dual = {p[0] * scale, p[1] * scale, p[2] * scale};
    });
    level.open.for_each([&](std::size_t i, std::size_t n) {
      const Eigen::Vector3i at = box.place(i);
      const Dual& dual = level.dual[level.kept.number(i)];
      float divergence = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool has_before = at[static_cast<int>(axis)] > 0;
        divergence += dual[axis] - (has_before ? level.dual[level.kept.number(i - stride[axis])][axis] : 0);
      }
      const float next = std::clamp(matter[n] + kStep * divergence, 0.0f, 1.0f);
      ahead[i] = 2 * next - matter[n];
      matter[n] = next;
    });
  }
  level.open.for_each([&](std::size_t i, std::size_t n) { level.matter[i] = matter[n]; });
}

/// Makes distances from the labels and smooths them, to remove steps of whole voxels and to fit the known distances at
/// the rim.
std::vector<float> smooth_distances(Level level, const KnownDistances& known) {
  constexpr float kFar = 2;  // known distances beyond this do not locate the surface
  const VoxelBox& box = level.box;
  std::vector<float> distance = std::move(level.matter);
  for_all(distance.size(), [&](std::size_t i) {
    distance[i] =
        level.labels[i] == VoxelLabel::kUnknown ? 1 - 2 * distance[i] : std::clamp(known.in_voxels(i), -kFar, kFar);
  });
  level.dual = {};
  std::vector<float> next(level.open.size());
  for (int step = 0; step < kSmoothSteps; ++step) {
    level.open.for_each([&](std::size_t i, std::size_t n) {
      const Eigen::Vector3i at = box.place(i);
      float sum = 0;
      float count = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t stride = box.stride(axis);
        if (at[axis] > 0) sum += distance[i - stride], count += 1;
        if (at[axis] + 1 < box.dims[axis]) sum += distance[i + stride], count += 1;
      }
      next[n] = sum / count;  // count > 0, because a box has more than one voxel
    });
    level.open.for_each([&](std::size_t i, std::size_t n) { distance[i] = next[n]; });
  }
  return distance;
}

/// What the finest level takes at most, beside the next coarser one: a float for each voxel, three bit sets with their
/// numbers, and for each open voxel its matter and its dual. The coarser levels, with a dual for each voxel, are not
/// larger.
std::size_t bytes_of_finest(const Level& level) {
  constexpr std::size_t kWordBytes = sizeof(std::uint64_t) + sizeof(std::uint32_t);
  const std::size_t coarser = level.box.voxels() / 8 * (2 * sizeof(float) + sizeof(Dual) + 4);
  return level.box.voxels() * sizeof(float) + 3 * level.box.voxels() / 64 * kWordBytes +
         level.kept.size() * sizeof(Dual) + level.open.size() * sizeof(float) + coarser;
}

}  // namespace

FilledField fill_by_smallest_surface(const VoxelBox& box, std::span<const VoxelLabel> labels,
                                     const KnownDistances& known, double band_voxels, std::size_t max_bytes) {
  std::vector<Level> levels(1);
  levels[0].box = box;
  levels[0].labels = labels;
  while (levels.back().box.dims.minCoeff() > 2 && levels.back().box.dims.maxCoeff() > kCoarsestSide) {
    levels.push_back(coarser(levels.back()));
  }
  FilledField filled;
  begin_coarsest(levels.back());
  solve(levels.back(), kFirstSteps);
  while (levels.size() > 1) {
    Level& fine = levels[levels.size() - 2];
    const double coarse_width = std::ldexp(1.0, static_cast<int>(levels.size()) - 1);  // voxels
    find_open(levels.back(), coarse_width <= band_voxels, fine);
    fine.kept = levels.size() > 2 ? all_of(fine.box) : changing_dual(fine);
    if (levels.size() == 2) filled.bytes = bytes_of_finest(fine);
    if (filled.bytes > max_bytes) return filled;
    begin_from(levels.back(), fine);
    levels.pop_back();
    solve(levels.back(), kSteps);
  }
  filled.distance_vox = smooth_distances(std::move(levels[0]), known);
  return filled;
}

}  // namespace scanknit
