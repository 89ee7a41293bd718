// A distance field as a scanner leaves it: known in a band round the surface, and only where it was seen.
#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "extract/extract_surface.h"
#include "finish/close_volume.h"

namespace scanknit::test {

inline constexpr double kVoxel = 0.004;
inline constexpr double kBand = 4;  // voxels

/// Signed distance, metres, negative inside.
using Shape = std::function<double(const Eigen::Vector3d&)>;
using Sight = std::function<bool(const Eigen::Vector3d&)>;

inline Shape ball(double radius_m, const Eigen::Vector3d& middle = Eigen::Vector3d::Zero()) {
  return [=](const Eigen::Vector3d& p) { return (p - middle).norm() - radius_m; };
}

inline Shape block(const Eigen::Vector3d& half) {
  return [=](const Eigen::Vector3d& p) {
    const Eigen::Vector3d q = p.cwiseAbs() - half;
    return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
  };
}

/// Round the z axis.
inline Shape ring(double radius_m, double thickness_m) {
  return [=](const Eigen::Vector3d& p) { return std::hypot(std::hypot(p.x(), p.y()) - radius_m, p.z()) - thickness_m; };
}

/// Samples within `reach_m` of the origin that are in the band and were seen.
inline openvdb::FloatGrid::Ptr scan_of(const Shape& shape, const Sight& was_seen, double reach_m = 0.12) {
  openvdb::initialize();
  const double band_m = kBand * kVoxel;
  auto grid = openvdb::FloatGrid::create(static_cast<float>(band_m));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(kVoxel));
  const int reach = static_cast<int>(std::ceil(reach_m / kVoxel));
  auto values = grid->getAccessor();
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const Eigen::Vector3d p = kVoxel * Eigen::Vector3d(x, y, z);
        const double distance = shape(p);
        if (std::abs(distance) > band_m || !was_seen(p)) continue;
        values.setValueOn({x, y, z}, static_cast<float>(distance));
      }
    }
  }
  return grid;
}

inline FieldView view_of(const openvdb::FloatGrid& grid) {
  FieldView view;
  view.field = &grid;
  return view;
}

inline Mesh mesh_of(const openvdb::FloatGrid& grid) {
  auto surface = extract_surface(view_of(grid), {});
  return surface ? std::move(surface->mesh) : Mesh();
}

inline Eigen::AlignedBox3d box_of(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& p : mesh.positions_m) box.extend(p.cast<double>());
  return box;
}

inline CloseRequest all_of(const Mesh& mesh) {
  CloseRequest request;
  request.surface = box_of(mesh);
  request.band_voxels = kBand;
  request.memory_bytes = std::size_t{1} << 30;
  return request;
}

}  // namespace scanknit::test
