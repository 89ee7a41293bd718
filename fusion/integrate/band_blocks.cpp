#include "fusion/integrate/band_blocks.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/check.h"

namespace scanknit {
namespace {

using openvdb::Coord;

constexpr int kBlock = 8;        // voxels along a leaf's edge
constexpr int kTaskBlocks = 16;  // octree nodes of this size are handed to the threads

/// A cube of size^3 blocks; `origin` is its lowest voxel.
struct Node {
  Coord origin;
  int blocks;
};

class BandSearch {
 public:
  BandSearch(const Observation& observation, const Pose& T_world_camera, double voxel_size_m)
      : bands_(observation.bands()), projector_(observation.intrinsics(), T_world_camera, voxel_size_m) {}

  /// Adds the parts of `node` that are `task_blocks` large and may meet the band to `tasks`, in a fixed order.
  void divide(const Node& node, int task_blocks, std::vector<Node>& tasks) const {
    const auto view = projector_.view(node.origin, kBlock * node.blocks);
    if (!view || !bands_.may_meet(view->pixels, view->z)) return;
    if (node.blocks == task_blocks) {
      tasks.push_back(node);
      return;
    }
    for (int child = 0; child < 8; ++child) divide({child_origin(node, child), node.blocks / 2}, task_blocks, tasks);
  }

  /// Adds the blocks of `node`, which may meet the band, that do to `found`, in a fixed order.
  void descend(const Node& node, std::vector<BandBlock>& found) const {
    const int half = node.blocks / 2;
    const auto views = projector_.views(node.origin, kBlock * half);
    for (int child = 0; child < 8; ++child) {
      const auto& view = views[static_cast<std::size_t>(child)];
      if (!view) continue;
      const Coord origin = child_origin(node, child);
      if (half == 1) {
        const DepthRanges::Sight sight = bands_.look(view->pixels, view->z);
        if (sight.meets) found.push_back({origin, sight.far_m});
      } else if (bands_.may_meet(view->pixels, view->z)) {
        descend({origin, half}, found);
      }
    }
  }

 private:
  static Coord child_origin(const Node& node, int child) {
    const int step = kBlock * node.blocks / 2;
    return node.origin + Coord((child & 1) * step, ((child >> 1) & 1) * step, (child >> 2) * step);
  }

  const DepthPyramid& bands_;
  SampleProjector projector_;
};

int floor_to_multiple(double value, int unit) {
  return static_cast<int>(std::floor(value / unit)) * unit;
}

/// The box, in the world, of the camera and all that its picture can show up to the end of the farthest band.
std::pair<Eigen::Vector3d, Eigen::Vector3d> frustum_bounds(const Observation& observation, const Pose& T_world_camera) {
  const CameraIntrinsics& k = observation.intrinsics();
  const double far_m = std::max(0.0, static_cast<double>(observation.bands().hull().far_m));
  Eigen::Vector3d low = T_world_camera.translation();
  Eigen::Vector3d high = low;
  for (int corner = 0; corner < 4; ++corner) {
    const double u = (corner & 1) != 0 ? k.width : -1;
    const double v = (corner & 2) != 0 ? k.height : -1;
    const Eigen::Vector3d p = T_world_camera * k.unproject(u, v, far_m);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {low, high};
}

/// The smallest cube of 2^n blocks, aligned to its task size, round the part of the frustum that holds the bands.
Node root_of(const Observation& observation, const Pose& T_world_camera, double voxel_size_m) {
  const auto [low, high] = frustum_bounds(observation, T_world_camera);
  constexpr int kUnit = kBlock * kTaskBlocks;
  const Eigen::Vector3d index = low / voxel_size_m;
  const Coord origin(floor_to_multiple(index.x(), kUnit), floor_to_multiple(index.y(), kUnit),
                     floor_to_multiple(index.z(), kUnit));
  const double side = ((high / voxel_size_m) - Eigen::Vector3d(origin.x(), origin.y(), origin.z())).maxCoeff();
  int blocks = kTaskBlocks;
  while (blocks * kBlock <= side) blocks *= 2;
  return {origin, blocks};
}

/// True if one of the node's regions is in the set. The node has the size of a task.
bool has_region_of(const Node& node, const RegionSet& regions) {
  static_assert(kTaskBlocks * kBlock == 2 * kRegionVoxels);
  for (int n = 0; n < 8; ++n) {
    const Coord offset(kRegionVoxels * (n & 1), kRegionVoxels * ((n >> 1) & 1), kRegionVoxels * (n >> 2));
    if (regions.contains(node.origin + offset)) return true;
  }
  return false;
}

}  // namespace

bool is_indexable(const Observation& observation, const Pose& T_world_camera, double voxel_size_m) {
  const auto [low, high] = frustum_bounds(observation, T_world_camera);
  const double farthest_m = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  // A quarter of the range leaves room for the octree's root, up to twice the frustum. False for NaN.
  return farthest_m / voxel_size_m < std::numeric_limits<int>::max() / 4;
}

std::optional<SampleProjector::View> SampleProjector::view(const Coord& origin, int side) const {
  return view_of(projector_.view(origin, 0, static_cast<float>(side - 1)));
}

std::array<std::optional<SampleProjector::View>, 8> SampleProjector::views(const Coord& origin, int side) const {
  const CubeViews cubes = projector_.views(origin, 0, static_cast<float>(side - 1), static_cast<float>(side));
  std::array<std::optional<View>, 8> views;
  for (Eigen::Index n = 0; n < 8; ++n) {
    views[static_cast<std::size_t>(n)] =
        view_of({cubes.x0[n], cubes.y0[n], cubes.x1[n], cubes.y1[n], cubes.near_m[n], cubes.far_m[n]});
  }
  return views;
}

std::optional<SampleProjector::View> SampleProjector::view_of(const CubeView& cube) const {
  if (!(cube.far_m > 0)) return std::nullopt;
  const DepthRange z{cube.near_m, cube.far_m};
  if (cube.reaches_behind(0)) return View{{0, 0, width_ - 1, height_ - 1}, z};  // it may project anywhere
  const auto pixel = [](float v, int size) {
    const float near = std::clamp(v, -2.0f, static_cast<float>(size) + 2.0f);
    return static_cast<int>(near + 2) - 2;  // floor, which is a call; rounding is within the rectangle's slack
  };
  return View{
      {pixel(cube.x0, width_), pixel(cube.y0, height_), pixel(cube.x1, width_) + 1, pixel(cube.y1, height_) + 1}, z};
}

Error too_far_from_origin() {
  return {ErrorCode::kInput, "the pose is too far from the world's origin for this voxel size"};
}

Error not_rigid() {
  return {ErrorCode::kInput, "the pose is not a rigid motion"};
}

bool SpaceInFront::meets(const Coord& origin, int side) const {
  constexpr float kNowhere_m = 1e30f;  // behind everything
  const auto view = projector_.view(origin, side);
  return view && observation_.bands().may_meet(view->pixels, {view->z.near_m, kNowhere_m});
}

std::vector<BandBlock> find_band_blocks(const Observation& observation, const Pose& T_world_camera, double voxel_size_m,
                                        const RegionSet* part) {
  SCANKNIT_CHECK(is_indexable(observation, T_world_camera, voxel_size_m));
  if (observation.bands().hull().far_m < 0) return {};  // no pixel has a return
  const BandSearch search(observation, T_world_camera, voxel_size_m);
  std::vector<Node> tasks;
  search.divide(root_of(observation, T_world_camera, voxel_size_m), kTaskBlocks, tasks);
  if (part != nullptr) std::erase_if(tasks, [&](const Node& node) { return !has_region_of(node, *part); });

  std::vector<std::vector<BandBlock>> found(tasks.size());
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) { search.descend(tasks[i], found[i]); });

  std::vector<BandBlock> all;
  for (const auto& blocks : found) {
    std::copy_if(blocks.begin(), blocks.end(), std::back_inserter(all),
                 [&](const BandBlock& block) { return part == nullptr || part->contains(region_of(block.origin)); });
  }
  return all;
}

}  // namespace scanknit
