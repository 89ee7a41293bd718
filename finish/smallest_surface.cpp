#include "finish/smallest_surface.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace scanknit {
namespace {

using Index = std::uint32_t;

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
  std::vector<VoxelLabel> labels;
  std::vector<float> matter;               ///< u of the paper, from 0 (free) to 1 (matter)
  std::vector<std::array<float, 3>> dual;  ///< p
  std::vector<Index> open;                 ///< voxels whose label is still to be found
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
  coarse.labels.resize(coarse.box.voxels());
  for_all(coarse.labels.size(), [&](std::size_t i) {
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
    coarse.labels[i] = has_matter == has_free ? VoxelLabel::kUnknown
                       : has_matter           ? VoxelLabel::kMatter
                                              : VoxelLabel::kFree;
  });
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

/// Starts a level from the coarser one's result. With `fixes_far_voxels`, voxels far from the surface keep that result.
void begin_from(const Level& coarse, bool fixes_far_voxels, Level& fine) {
  fine.matter.resize(fine.box.voxels());
  fine.dual.resize(fine.box.voxels());
  const std::vector<std::uint8_t> near = fixes_far_voxels ? near_surface(coarse) : std::vector<std::uint8_t>();
  std::vector<std::uint8_t> is_open(fine.box.voxels());
  for_all(fine.matter.size(), [&](std::size_t i) {
    const Eigen::Vector3i at = fine.box.place(i) / 2;
    const std::size_t parent = coarse.box.at(at.x(), at.y(), at.z());
    fine.dual[i] = coarse.dual[parent];
    const bool is_unknown = fine.labels[i] == VoxelLabel::kUnknown;
    const bool is_fixed = fixes_far_voxels && near[parent] == 0;
    const float from = coarse.matter[parent];
    fine.matter[i] = !is_unknown ? start_of(fine.labels[i]) : is_fixed ? std::round(from) : from;
    is_open[i] = is_unknown && !is_fixed ? 1 : 0;
  });
  for (std::size_t i = 0; i < is_open.size(); ++i) {
    if (is_open[i] != 0) fine.open.push_back(static_cast<Index>(i));
  }
}

void begin_coarsest(Level& level) {
  level.matter.resize(level.box.voxels());
  level.dual.assign(level.box.voxels(), {0, 0, 0});
  for (std::size_t i = 0; i < level.matter.size(); ++i) {
    level.matter[i] = start_of(level.labels[i]);
    if (level.labels[i] == VoxelLabel::kUnknown) level.open.push_back(static_cast<Index>(i));
  }
}

/// The voxels whose dual changes, each once: the open voxels, and the ones before them along an axis.
std::vector<Index> dual_places(const Level& level) {
  std::vector<std::uint8_t> is_there(level.box.voxels());
  for (const Index i : level.open) {
    const Eigen::Vector3i at = level.box.place(i);
    is_there[i] = 1;
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] > 0) is_there[i - level.box.stride(axis)] = 1;
    }
  }
  std::vector<Index> places;
  for (std::size_t i = 0; i < is_there.size(); ++i) {
    if (is_there[i] != 0) places.push_back(static_cast<Index>(i));
  }
  return places;
}

/// Chambolle & Pock 2011, algorithm 1, for the total variation of u with u between 0 and 1 and given where known.
void solve(Level& level, int steps) {
  const VoxelBox& box = level.box;
  const std::vector<Index> places = dual_places(level);
  std::vector<float> ahead = level.matter;  // u-bar
  const std::array<std::size_t, 3> stride = {box.stride(0), box.stride(1), box.stride(2)};
  for (int step = 0; step < steps; ++step) {
    for_all(places.size(), [&](std::size_t n) {
      const std::size_t i = places[n];
      const Eigen::Vector3i at = box.place(i);
      std::array<float, 3> p = level.dual[i];
      float squared = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool is_last = at[static_cast<int>(axis)] + 1 >= box.dims[static_cast<int>(axis)];
        p[axis] = is_last ? 0 : p[axis] + kStep * (ahead[i + stride[axis]] - ahead[i]);
        squared += p[axis] * p[axis];
      }
      const float scale = squared > 1 ? 1 / std::sqrt(squared) : 1.0f;
      level.dual[i] = {p[0] * scale, p[1] * scale, p[2] * scale};
    });
    for_all(level.open.size(), [&](std::size_t n) {
      const std::size_t i = level.open[n];
      const Eigen::Vector3i at = box.place(i);
      float divergence = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float before = at[static_cast<int>(axis)] > 0 ? level.dual[i - stride[axis]][axis] : 0;
        divergence += level.dual[i][axis] - before;
      }
      const float next = std::clamp(level.matter[i] + kStep * divergence, 0.0f, 1.0f);
      ahead[i] = 2 * next - level.matter[i];
      level.matter[i] = next;
    });
  }
}

/// Makes distances from the labels and smooths them, to remove steps of whole voxels and to fit the known distances at
/// the rim.
std::vector<float> smooth_distances(const Level& level, const std::vector<float>& known_vox) {
  constexpr float kFar = 2;  // known distances beyond this do not locate the surface
  const VoxelBox& box = level.box;
  std::vector<float> distance(box.voxels());
  for_all(distance.size(), [&](std::size_t i) {
    distance[i] =
        level.labels[i] == VoxelLabel::kUnknown ? 1 - 2 * level.matter[i] : std::clamp(known_vox[i], -kFar, kFar);
  });
  std::vector<float> next(level.open.size());
  for (int step = 0; step < kSmoothSteps; ++step) {
    for_all(level.open.size(), [&](std::size_t n) {
      const std::size_t i = level.open[n];
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
    for_all(level.open.size(), [&](std::size_t n) { distance[level.open[n]] = next[n]; });
  }
  return distance;
}

}  // namespace

FilledField fill_by_smallest_surface(const VoxelBox& box, const std::vector<VoxelLabel>& labels,
                                     const std::vector<float>& known_vox, double band_voxels) {
  std::vector<Level> levels(1);
  levels[0].box = box;
  levels[0].labels = labels;
  while (levels.back().box.dims.minCoeff() > 2 && levels.back().box.dims.maxCoeff() > kCoarsestSide) {
    levels.push_back(coarser(levels.back()));
  }
  begin_coarsest(levels.back());
  solve(levels.back(), kFirstSteps);
  while (levels.size() > 1) {
    Level& fine = levels[levels.size() - 2];
    const double coarse_width = std::ldexp(1.0, static_cast<int>(levels.size()) - 1);  // voxels
    begin_from(levels.back(), coarse_width <= band_voxels, fine);
    levels.pop_back();
    solve(levels.back(), kSteps);
  }
  return {smooth_distances(levels[0], known_vox)};
}

}  // namespace scanknit
