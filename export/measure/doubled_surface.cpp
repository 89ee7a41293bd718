#include "export/measure/doubled_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace scanknit {
namespace {

constexpr float kNearest = 1.5f, kFarthest = 6;  // voxels, along the normal
constexpr float kAside = 0.75f;                  // voxels, across it
constexpr float kStep = 0.5f;
constexpr float kLeastCosine = 0.8f;
constexpr std::size_t kMostSamples = 200'000;

using Cell = Eigen::Vector3i;

/// Vertices by the voxel in which they lie.
class VertexGrid {
 public:
  VertexGrid(const Mesh& mesh, double voxel_m) : per_voxel_(static_cast<float>(1 / voxel_m)) {
    places_.reserve(mesh.positions_m.size());
    for (const Eigen::Vector3f& p : mesh.positions_m) {
      places_.emplace_back(key_of(cell_of(p)), static_cast<std::uint32_t>(places_.size()));
    }
    std::size_t buckets = 1;
    while (buckets < 2 * places_.size()) buckets *= 2;
    std::sort(places_.begin(), places_.end());
    first_.assign(buckets, kNone);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (i > 0 && places_[i].first == places_[i - 1].first) continue;
      std::size_t bucket = places_[i].first & (buckets - 1);
      while (first_[bucket] != kNone) bucket = (bucket + 1) & (buckets - 1);
      first_[bucket] = static_cast<std::uint32_t>(i);
    }
  }

  [[nodiscard]] Cell cell_of(const Eigen::Vector3f& p_m) const {
    return (p_m * per_voxel_).array().floor().matrix().cast<int>();
  }

  /// Whether `is_wanted` is true of any vertex in the cell.
  template <typename IsWanted>
  [[nodiscard]] bool any_in(const Cell& cell, IsWanted is_wanted) const {
    const std::uint64_t key = key_of(cell);
    std::size_t bucket = key & (first_.size() - 1);
    for (; first_[bucket] != kNone; bucket = (bucket + 1) & (first_.size() - 1)) {
      if (places_[first_[bucket]].first != key) continue;
      for (std::size_t i = first_[bucket]; i < places_.size() && places_[i].first == key; ++i) {
        if (is_wanted(places_[i].second)) return true;
      }
      return false;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// Distinct for cells of a volume of two million voxels a side, and well mixed (splitmix64: Steele et al. 2014).
  static std::uint64_t key_of(const Cell& cell) {
    constexpr std::uint64_t kBits = 21, kMask = (1U << kBits) - 1;
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) key = key << kBits | (static_cast<std::uint64_t>(cell[axis]) & kMask);
    key = (key ^ key >> 30) * 0xbf58476d1ce4e5b9ULL;
    key = (key ^ key >> 27) * 0x94d049bb133111ebULL;
    return key ^ key >> 31;
  }

  float per_voxel_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> places_;  ///< key, vertex; sorted
  std::vector<std::uint32_t> first_;                             ///< by bucket: the first place of a key
};

class Doubling {
 public:
  Doubling(const Mesh& mesh, double voxel_m)
      : mesh_(mesh), voxel_m_(static_cast<float>(voxel_m)), grid_(mesh, voxel_m) {}

  [[nodiscard]] bool is_doubled(std::size_t vertex) const {
    const Eigen::Vector3f& p = mesh_.positions_m[vertex];
    const Eigen::Vector3f& n = mesh_.normals[vertex];
    const auto is_other_sheet = [&](std::uint32_t other) {
      const Eigen::Vector3f apart = (mesh_.positions_m[other] - p) / voxel_m_;
      const float along = apart.dot(n);
      return std::abs(along) >= kNearest && std::abs(along) <= kFarthest && (apart - along * n).norm() <= kAside &&
             mesh_.normals[other].dot(n) >= kLeastCosine;
    };
    for (const float side : {-1.0f, 1.0f}) {
      Cell last = grid_.cell_of(p);
      for (float away = kNearest; away <= kFarthest; away += kStep) {
        const Cell cell = grid_.cell_of(p + side * away * voxel_m_ * n);
        if (cell != last && grid_.any_in(cell, is_other_sheet)) return true;
        last = cell;
      }
    }
    return false;
  }

 private:
  const Mesh& mesh_;
  float voxel_m_;
  VertexGrid grid_;
};

/// A third of its triangles' area for each vertex, square metres.
std::vector<double> areas_of(const Mesh& mesh) {
  std::vector<double> areas(mesh.positions_m.size(), 0.0);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f ab = mesh.positions_m[b] - mesh.positions_m[a];
    const Eigen::Vector3f ac = mesh.positions_m[c] - mesh.positions_m[a];
    const double third = static_cast<double>(ab.cross(ac).norm()) / 6;
    for (const std::uint32_t vertex : {a, b, c}) areas[vertex] += third;
  }
  return areas;
}

}  // namespace

DoubledSurface find_doubled_surface(const Mesh& mesh, double voxel_m) {
  DoubledSurface found;
  if (mesh.empty() || mesh.normals.size() != mesh.positions_m.size() || !(voxel_m > 0)) return found;
  const std::vector<double> areas = areas_of(mesh);
  const std::size_t every = (mesh.positions_m.size() + kMostSamples - 1) / kMostSamples;
  const Doubling doubling(mesh, voxel_m);
  std::vector<std::uint8_t> is_doubled((mesh.positions_m.size() + every - 1) / every);
  tbb::parallel_for(std::size_t{0}, is_doubled.size(),
                    [&](std::size_t i) { is_doubled[i] = doubling.is_doubled(i * every); });
  double sampled = 0, doubled = 0, whole = 0;
  for (std::size_t i = 0; i < is_doubled.size(); ++i) {
    sampled += areas[i * every];
    if (is_doubled[i] != 0) doubled += areas[i * every];
  }
  for (const double area : areas) whole += area;
  found.share = sampled > 0 ? doubled / sampled : 0;
  found.area_m2 = found.share * whole;
  return found;
}

}  // namespace scanknit
