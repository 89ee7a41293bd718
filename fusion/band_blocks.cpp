#include "fusion/band_blocks.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
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
  [[nodiscard]] Coord last() const { return origin.offsetBy(kBlock * blocks - 1); }
};

class BandSearch {
 public:
  BandSearch(const Observation& observation, const Pose& T_world_camera, double voxel_size_m)
      : bands_(observation.bands()), projector_(observation.intrinsics(), T_world_camera, voxel_size_m) {}

  /// Adds the parts of `node` of at most `stop_blocks` that meet the band to `found`, in a fixed order.
  void descend(const Node& node, int stop_blocks, std::vector<Node>& found) const {
    const BoxView view = projector_.view(node.origin, node.last());
    if (!view.is_in_front) return;
    if (node.blocks == 1) {
      if (bands_.meets(view.pixels, view.z)) found.push_back(node);
      return;
    }
    if (!bands_.may_meet(view.pixels, view.z)) return;
    if (node.blocks <= stop_blocks) {
      found.push_back(node);
      return;
    }
    const int half = node.blocks / 2;
    const int step = kBlock * half;
    for (int child = 0; child < 8; ++child) {
      const Coord offset((child & 1) * step, ((child >> 1) & 1) * step, (child >> 2) * step);
      descend({node.origin + offset, half}, stop_blocks, found);
    }
  }

 private:
  const DepthPyramid& bands_;
  BoxProjector projector_;
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

}  // namespace

bool is_indexable(const Observation& observation, const Pose& T_world_camera, double voxel_size_m) {
  const auto [low, high] = frustum_bounds(observation, T_world_camera);
  const double farthest_m = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  // A quarter of the range leaves room for the octree's root, up to twice the frustum. False for NaN.
  return farthest_m / voxel_size_m < std::numeric_limits<int>::max() / 4;
}

BoxProjector::BoxProjector(const CameraIntrinsics& intrinsics, const Pose& T_world_camera, double voxel_size_m)
    : intrinsics_(intrinsics), T_camera_world_(T_world_camera.inverse()), voxel_size_m_(voxel_size_m) {
  abs_rotation_ = T_camera_world_.linear().cwiseAbs();
}

BoxView BoxProjector::view(const Coord& first, const Coord& last) const {
  const Eigen::Vector3d a = Eigen::Vector3d(first.x(), first.y(), first.z()) * voxel_size_m_;
  const Eigen::Vector3d b = Eigen::Vector3d(last.x(), last.y(), last.z()) * voxel_size_m_;
  const Eigen::Vector3d centre = T_camera_world_ * (0.5 * (a + b));
  const Eigen::Vector3d half = abs_rotation_ * (0.5 * (b - a));
  const double z0 = centre.z() - half.z();
  const double z1 = centre.z() + half.z();

  BoxView view;
  view.is_in_front = z1 > 0;
  if (!view.is_in_front) return view;
  view.z = {static_cast<float>(z0), static_cast<float>(z1)};
  if (z0 <= 0) {  // reaches behind the camera: it may project anywhere
    view.pixels = {0, 0, intrinsics_.width - 1, intrinsics_.height - 1};
    return view;
  }
  const auto extent = [&](double low, double high, double focal, double centre_px, int size, int& from, int& to) {
    const double lowest = std::min(low / z0, low / z1);
    const double highest = std::max(high / z0, high / z1);
    const double p = focal * lowest + centre_px;
    const double q = focal * highest + centre_px;
    from = static_cast<int>(std::floor(std::clamp(std::min(p, q), -2.0, size + 2.0)));
    to = static_cast<int>(std::floor(std::clamp(std::max(p, q), -2.0, size + 2.0))) + 1;
  };
  extent(centre.x() - half.x(), centre.x() + half.x(), intrinsics_.fx, intrinsics_.cx, intrinsics_.width,
         view.pixels.x0, view.pixels.x1);
  extent(centre.y() - half.y(), centre.y() + half.y(), intrinsics_.fy, intrinsics_.cy, intrinsics_.height,
         view.pixels.y0, view.pixels.y1);
  return view;
}

std::vector<Coord> find_band_blocks(const Observation& observation, const Pose& T_world_camera, double voxel_size_m) {
  SCANKNIT_CHECK(is_indexable(observation, T_world_camera, voxel_size_m));
  if (observation.bands().hull().far_m < 0) return {};  // no pixel has a return
  const BandSearch search(observation, T_world_camera, voxel_size_m);
  std::vector<Node> tasks;
  search.descend(root_of(observation, T_world_camera, voxel_size_m), kTaskBlocks, tasks);

  std::vector<std::vector<Node>> found(tasks.size());
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) { search.descend(tasks[i], 1, found[i]); });

  std::vector<Coord> origins;
  for (const auto& part : found) {
    for (const Node& node : part) origins.push_back(node.origin);
  }
  return origins;
}

}  // namespace scanknit
