// VoxelBox: a box of voxels as one array.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace scanknit {

/// `dims` voxels from `first`, the index of a voxel in its volume. z runs fastest.
struct VoxelBox {
  Eigen::Vector3i first = Eigen::Vector3i::Zero();
  Eigen::Vector3i dims = Eigen::Vector3i::Zero();

  [[nodiscard]] std::size_t voxels() const {
    return static_cast<std::size_t>(dims.x()) * static_cast<std::size_t>(dims.y()) * static_cast<std::size_t>(dims.z());
  }
  [[nodiscard]] std::size_t stride(int axis) const {
    const auto z = static_cast<std::size_t>(dims.z());
    return axis == 2 ? 1 : axis == 1 ? z : z * static_cast<std::size_t>(dims.y());
  }
  /// The array index of a voxel; x, y, z count from `first`.
  [[nodiscard]] std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(dims.y()) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(dims.z()) +
           static_cast<std::size_t>(z);
  }
  [[nodiscard]] bool contains(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < dims.x() && y < dims.y() && z < dims.z();
  }
  [[nodiscard]] Eigen::Vector3i place(std::size_t at) const {
    const auto z = static_cast<int>(at % static_cast<std::size_t>(dims.z()));
    const std::size_t rest = at / static_cast<std::size_t>(dims.z());
    return {static_cast<int>(rest / static_cast<std::size_t>(dims.y())),
            static_cast<int>(rest % static_cast<std::size_t>(dims.y())), z};
  }
};

}  // namespace scanknit
