#include "fusion/raycast.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "fusion/band_blocks.h"
#include "fusion/luma.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using FloatLeaf = openvdb::FloatTree::LeafNodeType;

constexpr int kBlock = 8;
constexpr int kTile = 8;             // pixels a side, for which one range of depth is known
constexpr float kNearest_m = 0.05f;  // no surface is looked for nearer than this
constexpr float kCaution = 0.8f;     // of the distance to the surface is stepped: it was measured from another side

/// All reading of voxels. Coordinates in voxels. One for each thread.
class Voxels {
 public:
  explicit Voxels(const TsdfVolume& volume)
      : tsdf_(volume.tsdf().getConstAccessor()), colour_(volume.colour().getConstAccessor()) {}

  [[nodiscard]] const FloatLeaf* block_at(const Coord& voxel) { return tsdf_.probeConstLeaf(voxel); }

  struct Field {
    float value;               ///< metres
    Eigen::Vector3f gradient;  ///< metres a voxel
  };

  /// Trilinear; nothing where one of the eight voxels is unknown.
  [[nodiscard]] std::optional<Field> field_at(const Eigen::Vector3f& p) {
    const Coord low = floor_of(p);
    std::array<float, 8> v;
    for (int corner = 0; corner < 8; ++corner) {
      if (!tsdf_.probeValue(corner_of(low, corner), v[static_cast<std::size_t>(corner)])) return std::nullopt;
    }
    const Eigen::Vector3f f = p - vector_of(low);
    const auto mix = [](float a, float b, float share) { return a + (b - a) * share; };
    // Along x first, then y, then z; corner = x + 2 y + 4 z.
    const float x00 = mix(v[0], v[1], f.x()), x10 = mix(v[2], v[3], f.x());
    const float x01 = mix(v[4], v[5], f.x()), x11 = mix(v[6], v[7], f.x());
    const float y0 = mix(x00, x10, f.y()), y1 = mix(x01, x11, f.y());
    const float dx0 = mix(v[1] - v[0], v[3] - v[2], f.y()), dx1 = mix(v[5] - v[4], v[7] - v[6], f.y());
    return Field{mix(y0, y1, f.z()), {mix(dx0, dx1, f.z()), mix(x10 - x00, x11 - x01, f.z()), y1 - y0}};
  }

  /// Trilinear over the voxels whose colour is known; negative when none is.
  [[nodiscard]] float intensity_at(const Eigen::Vector3f& p) {
    const Coord low = floor_of(p);
    const Eigen::Vector3f f = p - vector_of(low);
    float sum = 0;
    float weights = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const openvdb::Vec3s& colour = colour_.getValue(corner_of(low, corner));
      if (colour.x() < 0) continue;
      const float weight = ((corner & 1) != 0 ? f.x() : 1 - f.x()) * ((corner & 2) != 0 ? f.y() : 1 - f.y()) *
                           ((corner & 4) != 0 ? f.z() : 1 - f.z());
      sum += weight * luma(colour.x(), colour.y(), colour.z());
      weights += weight;
    }
    return weights > 0 ? sum / weights : -1;
  }

 private:
  [[nodiscard]] static Coord floor_of(const Eigen::Vector3f& p) {
    return {static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
            static_cast<int>(std::floor(p.z()))};
  }
  [[nodiscard]] static Coord corner_of(const Coord& low, int corner) {
    return low.offsetBy(corner & 1, (corner >> 1) & 1, corner >> 2);
  }
  [[nodiscard]] static Eigen::Vector3f vector_of(const Coord& c) {
    return {static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z())};
  }

  openvdb::FloatGrid::ConstAccessor tsdf_;
  openvdb::Vec3SGrid::ConstAccessor colour_;
};

/// Between which depths the blocks of the volume lie, tile by tile.
Image<DepthRange> ranges_of(const TsdfVolume& volume, const CameraIntrinsics& k, const Pose& T_world_camera) {
  Image<DepthRange> tiles((k.width + kTile - 1) / kTile, (k.height + kTile - 1) / kTile);
  const BoxProjector projector(k, T_world_camera, volume.config().voxel_size_m);
  for (auto leaf = volume.tsdf().tree().cbeginLeaf(); leaf; ++leaf) {
    const Coord origin = leaf->origin();
    const BoxView view = projector.view(origin.offsetBy(-1), origin.offsetBy(kBlock));
    if (!view.is_in_front || view.pixels.x1 < 0 || view.pixels.y1 < 0) continue;
    for (int y = std::max(view.pixels.y0, 0) / kTile; y <= std::min(view.pixels.y1, k.height - 1) / kTile; ++y) {
      for (int x = std::max(view.pixels.x0, 0) / kTile; x <= std::min(view.pixels.x1, k.width - 1) / kTile; ++x) {
        DepthRange& range = tiles.at(x, y);
        range.near_m = std::min(range.near_m, view.z.near_m);
        range.far_m = std::max(range.far_m, view.z.far_m);
      }
    }
  }
  return tiles;
}

/// A ray in voxels: `start` + z `step` is where its depth is z metres.
struct Ray {
  Eigen::Vector3f start, step;
  float voxel_z_m;  ///< depth in which it passes one voxel's length
  [[nodiscard]] Eigen::Vector3f at(float z_m) const { return start + z_m * step; }
};

struct Hit {
  float z_m;
  Eigen::Vector3f p;  ///< voxels
  Eigen::Vector3f gradient;
};

/// The zero between `outside` (positive) and `inside` by regula falsi on the trilinear field.
std::optional<Hit> refine(Voxels& voxels, const Ray& ray, float outside_z_m, float inside_z_m) {
  auto outside = voxels.field_at(ray.at(outside_z_m));
  auto inside = voxels.field_at(ray.at(inside_z_m));
  // The nearest voxels, which the march looked at, may have other signs than the field between them.
  for (int i = 0; i < 2 && outside && outside->value <= 0; ++i) {
    inside_z_m = outside_z_m;
    inside = outside;
    outside_z_m -= ray.voxel_z_m;
    outside = voxels.field_at(ray.at(outside_z_m));
  }
  for (int i = 0; i < 2 && inside && inside->value > 0; ++i) {
    outside_z_m = inside_z_m;
    outside = inside;
    inside_z_m += ray.voxel_z_m;
    inside = voxels.field_at(ray.at(inside_z_m));
  }
  if (!outside || !inside || !(outside->value > 0) || inside->value > 0) return std::nullopt;
  constexpr int kRounds = 3;
  for (int round = 0;; ++round) {
    const float share = outside->value / (outside->value - inside->value);
    const float z_m = outside_z_m + share * (inside_z_m - outside_z_m);
    const auto middle = voxels.field_at(ray.at(z_m));
    if (!middle) return std::nullopt;
    if (round == kRounds) return Hit{z_m, ray.at(z_m), middle->gradient};
    if (middle->value > 0) {
      outside = middle;
      outside_z_m = z_m;
    } else {
      inside = middle;
      inside_z_m = z_m;
    }
  }
}

Coord nearest_voxel(const Eigen::Vector3f& p) {
  return {static_cast<int>(std::floor(p.x() + 0.5f)), static_cast<int>(std::floor(p.y() + 0.5f)),
          static_cast<int>(std::floor(p.z() + 0.5f))};
}

/// The depth at which the ray leaves the block of `voxel`.
float end_of_block(const Ray& ray, const Coord& voxel) {
  float z_m = 1e30f;
  for (int axis = 0; axis < 3; ++axis) {
    const float step = ray.step[axis];
    if (step == 0) continue;
    const int low = voxel[axis] & ~(kBlock - 1);
    const float wall = static_cast<float>(step > 0 ? low + kBlock : low) - 0.5f;
    z_m = std::min(z_m, (wall - ray.start[axis]) / step);
  }
  return z_m;
}

std::optional<Hit> march(Voxels& voxels, const Ray& ray, const DepthRange& range, float voxel_size_m) {
  float outside_z_m = 0;  // the last place in free space; 0: unknown or matter came after it
  float z_m = std::max(range.near_m, kNearest_m);
  while (z_m < range.far_m) {
    const Coord voxel = nearest_voxel(ray.at(z_m));
    const FloatLeaf* block = voxels.block_at(voxel);
    if (block == nullptr) {
      outside_z_m = 0;
      z_m = std::max(end_of_block(ray, voxel), z_m) + 0.01f * ray.voxel_z_m;
      continue;
    }
    const openvdb::Index offset = FloatLeaf::coordToOffset(voxel);
    if (!block->isValueOn(offset)) {
      outside_z_m = 0;
      z_m += ray.voxel_z_m;
      continue;
    }
    const float value = block->getValue(offset);
    if (value > 0) {
      outside_z_m = z_m;
      z_m += std::max(kCaution * value / voxel_size_m, 0.5f) * ray.voxel_z_m;
    } else {
      if (outside_z_m == 0) return std::nullopt;  // from behind
      return refine(voxels, ray, outside_z_m, z_m);
    }
  }
  return std::nullopt;
}

}  // namespace

ModelView raycast(const TsdfVolume& volume, const CameraIntrinsics& k, const Pose& T_world_camera) {
  ModelView view{k, T_world_camera, DepthImage(k.width, k.height),
                 Image<Eigen::Vector3f>(k.width, k.height, Eigen::Vector3f::Zero()),
                 Image<float>(k.width, k.height, -1.0f)};
  const double voxel_size_m = volume.config().voxel_size_m;
  const Image<DepthRange> ranges = ranges_of(volume, k, T_world_camera);
  const Eigen::Vector3f start = (T_world_camera.translation() / voxel_size_m).cast<float>();
  const Eigen::Matrix3f R_camera_world = T_world_camera.linear().transpose().cast<float>();

  tbb::parallel_for(0, k.height, [&](int y) {
    Voxels voxels(volume);
    for (int x = 0; x < k.width; ++x) {
      const DepthRange& range = ranges.at(x / kTile, y / kTile);
      if (range.near_m > range.far_m) continue;
      const Eigen::Vector3d along = k.unproject(x, y, 1.0);
      const Ray ray{start, (T_world_camera.linear() * along / voxel_size_m).cast<float>(),
                    static_cast<float>(voxel_size_m / along.norm())};
      const auto hit = march(voxels, ray, range, static_cast<float>(voxel_size_m));
      if (!hit) continue;
      const Eigen::Vector3f normal = (R_camera_world * hit->gradient).normalized();
      if (!(normal.dot(along.cast<float>()) < 0)) continue;
      view.depth_m.at(x, y) = hit->z_m;
      view.normals.at(x, y) = normal;
      view.intensity.at(x, y) = voxels.intensity_at(hit->p);
    }
  });
  return view;
}

}  // namespace scanknit
