#include "fusion/raycast.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "fusion/depth_pyramid.h"
#include "fusion/luma.h"
#include "fusion/voxel_reader.h"

namespace scanknit {
namespace {

constexpr int kTile = 8;             // pixels a side, for which one range of depth is known
constexpr float kNearest_m = 0.05f;  // no surface is looked for nearer than this
constexpr float kCaution = 0.8f;     // of the distance to the surface is stepped: it was measured from another side

/// Between which depths the blocks with matter lie, tile by tile; each reaches two voxels beyond its samples, so that
/// free space before a surface is seen, too.
class TileRanges {
 public:
  TileRanges(const CameraIntrinsics& k, const Pose& T_world_camera, double voxel_size_m)
      : width_(k.width),
        height_(k.height),
        tiles_((k.width + kTile - 1) / kTile, (k.height + kTile - 1) / kTile),
        R_camera_world_((T_world_camera.linear().transpose() * voxel_size_m).cast<float>()),
        t_camera_world_(T_world_camera.inverse().translation().cast<float>()),
        fx_(static_cast<float>(k.fx)),
        fy_(static_cast<float>(k.fy)),
        cx_(static_cast<float>(k.cx)),
        cy_(static_cast<float>(k.cy)),
        voxel_size_m_(static_cast<float>(voxel_size_m)) {}

  void add(const BlockIndex& index) {
    for (const BlockIndex::Region& region : index.regions()) {
      if (!sees(region.origin, BlockIndex::kRegionVoxels)) continue;
      for (const BlockIndex::Number number : region.blocks) {
        const VolumeBlock& block = index.blocks()[number];
        if (block.has_matter && !block.is_free) add_block(block.origin);
      }
    }
  }

  [[nodiscard]] const DepthRange& at(int x, int y) const { return tiles_.at(x / kTile, y / kTile); }

 private:
  /// The ball round a cube and two voxels more.
  struct Ball {
    Eigen::Vector3f centre;
    float radius_m;
  };
  [[nodiscard]] Ball ball_of(const openvdb::Coord& origin, int side) const {
    const float half = 0.5f * static_cast<float>(side - 1);
    const Eigen::Vector3f centre(static_cast<float>(origin.x()) + half, static_cast<float>(origin.y()) + half,
                                 static_cast<float>(origin.z()) + half);
    constexpr float kSqrt3 = 1.7320509f;
    return {R_camera_world_ * centre + t_camera_world_, (half * kSqrt3 + 2) * voxel_size_m_};
  }

  /// False only where a cube is not in the picture.
  [[nodiscard]] bool sees(const openvdb::Coord& origin, int side) const {
    const Ball ball = ball_of(origin, side);
    if (ball.centre.z() + ball.radius_m < kNearest_m) return false;
    if (ball.centre.z() - ball.radius_m < kNearest_m) return true;
    int x0, y0, x1, y1;
    return pixels_of(ball, x0, y0, x1, y1);
  }

  /// The pixels on which a ball in front of the camera may lie; false when none.
  [[nodiscard]] bool pixels_of(const Ball& ball, int& x0, int& y0, int& x1, int& y1) const {
    const float per_z = 1 / (ball.centre.z() - ball.radius_m);
    const auto extent = [&](float centre, float focal, float principal, int size, int& from, int& to) {
      // The ball's outline reaches no farther than the box from centre - radius to centre + radius at its least depth
      // or its greatest; both ends are tried.
      const float far_per_z = 1 / (ball.centre.z() + ball.radius_m);
      const auto project = [&](float v) { return std::pair(focal * v * per_z, focal * v * far_per_z); };
      const auto [a, b] = project(centre - ball.radius_m);
      const auto [c, d] = project(centre + ball.radius_m);
      const float low = std::min(std::min(a, b), std::min(c, d)) + principal;
      const float high = std::max(std::max(a, b), std::max(c, d)) + principal;
      const auto limit = static_cast<float>(size);
      from = static_cast<int>(std::clamp(low, 0.0f, limit));
      to = static_cast<int>(std::clamp(high + 1, 0.0f, limit - 1));
      return high >= -1 && low <= limit;
    };
    return extent(ball.centre.x(), fx_, cx_, width_, x0, x1) && extent(ball.centre.y(), fy_, cy_, height_, y0, y1);
  }

  void add_block(const openvdb::Coord& origin) {
    constexpr int kSide = 8;
    const Ball ball = ball_of(origin, kSide);
    const DepthRange range{ball.centre.z() - ball.radius_m, ball.centre.z() + ball.radius_m};
    if (range.far_m < kNearest_m) return;
    int x0 = 0, y0 = 0, x1 = width_ - 1, y1 = height_ - 1;
    if (range.near_m >= kNearest_m && !pixels_of(ball, x0, y0, x1, y1)) return;
    for (int y = y0 / kTile; y <= y1 / kTile; ++y) {
      for (int x = x0 / kTile; x <= x1 / kTile; ++x) {
        DepthRange& tile = tiles_.at(x, y);
        tile.near_m = std::min(tile.near_m, range.near_m);
        tile.far_m = std::max(tile.far_m, range.far_m);
      }
    }
  }

  int width_, height_;
  Image<DepthRange> tiles_;
  Eigen::Matrix3f R_camera_world_;  ///< and voxels to metres
  Eigen::Vector3f t_camera_world_;
  float fx_, fy_, cx_, cy_;
  float voxel_size_m_;
};

/// A ray in voxels: `start` + z `step` is where its depth is z metres.
struct Ray {
  Eigen::Vector3f start, step;
  float voxel_z_m;  ///< depth in which it passes one voxel's length
  [[nodiscard]] Eigen::Vector3f at(float z_m) const { return start + z_m * step; }
};

struct Hit {
  float z_m;
  Eigen::Vector3f gradient;  ///< metres a voxel
};

/// Follows one ray after the other through the volume.
class Marcher {
 public:
  Marcher(const BlockIndex& index, float voxel_size_m) : voxels_(index), per_voxel_(1 / voxel_size_m) {}

  [[nodiscard]] std::optional<Hit> march(const Ray& ray, const DepthRange& range) {
    constexpr float kUnknown = 0;
    float outside_z_m = kUnknown;  // the last place in free space, if only free space came after it
    float z_m = std::max(range.near_m, kNearest_m);
    while (z_m < range.far_m) {
      const VoxelReader::At at = VoxelReader::floor_of(ray.at(z_m) + Eigen::Vector3f::Constant(0.5f));
      const VolumeBlock* block = voxels_.block_at(at);
      if (block == nullptr) {
        outside_z_m = kUnknown;
        z_m = std::max(end_of_block(ray, at), z_m) + 0.01f * ray.voxel_z_m;
        continue;
      }
      const unsigned offset = VoxelReader::offset_of(at);
      if (!VoxelReader::is_observed(*block, offset)) {
        outside_z_m = kUnknown;
        z_m += ray.voxel_z_m;
        continue;
      }
      const float value = block->tsdf->buffer().data()[offset];
      if (value > 0) {
        outside_z_m = z_m;
        z_m += std::max(kCaution * value * per_voxel_, 0.5f) * ray.voxel_z_m;
      } else {
        if (outside_z_m == kUnknown) return std::nullopt;  // from behind
        return refine(ray, outside_z_m, z_m);
      }
    }
    return std::nullopt;
  }

  /// Luma of the mean colour, trilinear over the voxels that have one; negative when none has.
  [[nodiscard]] float intensity_at(const Eigen::Vector3f& p) {
    const VoxelReader::At low = VoxelReader::floor_of(p);
    const Eigen::Vector3f f = share_of(p, low);
    Cell<ColourCode> codes;
    voxels_.colours(low, codes);
    float sum = 0;
    float weights = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const float weight = ((corner & 1) != 0 ? f.x() : 1 - f.x()) * ((corner & 2) != 0 ? f.y() : 1 - f.y()) *
                           ((corner & 4) != 0 ? f.z() : 1 - f.z());
      const float counted = has_colour(codes[corner]) ? weight : 0;
      const Rgb8 colour = decode_colour(codes[corner]);
      sum += counted * luma(colour.r, colour.g, colour.b);
      weights += counted;
    }
    return weights > 0 ? sum / (255 * weights) : -1;
  }

 private:
  struct Field {
    float value;
    Eigen::Vector3f gradient;
  };

  [[nodiscard]] static Eigen::Vector3f share_of(const Eigen::Vector3f& p, const VoxelReader::At& low) {
    return p - Eigen::Vector3f(static_cast<float>(low.x), static_cast<float>(low.y), static_cast<float>(low.z));
  }
  static float mix(float a, float b, float share) { return a + (b - a) * share; }

  /// Trilinear; false where one of the eight voxels is unknown.
  [[nodiscard]] bool field_at(const Eigen::Vector3f& p, Field& field) {
    const VoxelReader::At low = VoxelReader::floor_of(p);
    Cell<float> v;
    if (!voxels_.distances(low, v)) return false;
    const Eigen::Vector3f f = share_of(p, low);
    const float x00 = mix(v[0], v[1], f.x()), x10 = mix(v[2], v[3], f.x());
    const float x01 = mix(v[4], v[5], f.x()), x11 = mix(v[6], v[7], f.x());
    const float y0 = mix(x00, x10, f.y()), y1 = mix(x01, x11, f.y());
    const float dx0 = mix(v[1] - v[0], v[3] - v[2], f.y()), dx1 = mix(v[5] - v[4], v[7] - v[6], f.y());
    field = {mix(y0, y1, f.z()), {mix(dx0, dx1, f.z()), mix(x10 - x00, x11 - x01, f.z()), y1 - y0}};
    return true;
  }

  /// The zero of the trilinear field between a place in free space and one in matter, as the nearest voxels say. Regula
  /// falsi from the two, once; then Newton's step with the field's own gradient.
  [[nodiscard]] std::optional<Hit> refine(const Ray& ray, float outside_z_m, float inside_z_m) {
    Field outside, inside;
    if (!field_at(ray.at(outside_z_m), outside) || !field_at(ray.at(inside_z_m), inside)) return std::nullopt;
    // The nearest voxels may have other signs than the field between them.
    for (int i = 0; i < 2 && outside.value <= 0; ++i) {
      inside = outside;
      inside_z_m = outside_z_m;
      outside_z_m -= ray.voxel_z_m;
      if (!field_at(ray.at(outside_z_m), outside)) return std::nullopt;
    }
    for (int i = 0; i < 2 && inside.value > 0; ++i) {
      outside = inside;
      outside_z_m = inside_z_m;
      inside_z_m += ray.voxel_z_m;
      if (!field_at(ray.at(inside_z_m), inside)) return std::nullopt;
    }
    if (!(outside.value > 0) || inside.value > 0) return std::nullopt;
    const float share = outside.value / (outside.value - inside.value);
    const float z_m = mix(outside_z_m, inside_z_m, share);
    Field middle;
    if (!field_at(ray.at(z_m), middle)) return std::nullopt;
    const float slope = middle.gradient.dot(ray.step);
    const float newton_z_m = slope < 0 ? z_m - middle.value / slope : z_m;
    return Hit{std::clamp(newton_z_m, outside_z_m, inside_z_m), middle.gradient};
  }

  /// The depth at which the ray leaves the block of samples round `at`.
  [[nodiscard]] static float end_of_block(const Ray& ray, const VoxelReader::At& at) {
    constexpr int kSide = 8;
    float z_m = 1e30f;
    const auto clip = [&](int axis, int sample) {
      const float step = ray.step[axis];
      if (step == 0) return;
      const int low = sample & ~(kSide - 1);
      const float wall = static_cast<float>(step > 0 ? low + kSide : low) - 0.5f;
      z_m = std::min(z_m, (wall - ray.start[axis]) / step);
    };
    clip(0, at.x);
    clip(1, at.y);
    clip(2, at.z);
    return z_m;
  }

  VoxelReader voxels_;
  float per_voxel_;
};

}  // namespace

ModelView raycast(const TsdfVolume& volume, const CameraIntrinsics& k, const Pose& T_world_camera) {
  ModelView view{k, T_world_camera, DepthImage(k.width, k.height),
                 Image<Eigen::Vector3f>(k.width, k.height, Eigen::Vector3f::Zero()),
                 Image<float>(k.width, k.height, -1.0f)};
  const double voxel_size_m = volume.config().voxel_size_m;
  TileRanges ranges(k, T_world_camera, voxel_size_m);
  ranges.add(volume.index());
  const Eigen::Vector3f start = (T_world_camera.translation() / voxel_size_m).cast<float>();
  const Eigen::Matrix3f step_of_ray = (T_world_camera.linear() / voxel_size_m).cast<float>();
  const Eigen::Matrix3f R_camera_world = T_world_camera.linear().transpose().cast<float>();

  tbb::parallel_for(0, (k.height + kTile - 1) / kTile, [&](int tile_y) {
    Marcher marcher(volume.index(), static_cast<float>(voxel_size_m));
    for (int y = kTile * tile_y; y < std::min(kTile * (tile_y + 1), k.height); ++y) {
      for (int x = 0; x < k.width; ++x) {
        const DepthRange& range = ranges.at(x, y);
        if (range.near_m > range.far_m) continue;
        const Eigen::Vector3f along = k.unproject(x, y, 1.0).cast<float>();
        const Ray ray{start, step_of_ray * along, static_cast<float>(voxel_size_m) / along.norm()};
        const auto hit = marcher.march(ray, range);
        if (!hit) continue;
        const Eigen::Vector3f normal = (R_camera_world * hit->gradient).normalized();
        if (!(normal.dot(along) < 0)) continue;
        view.depth_m.at(x, y) = hit->z_m;
        view.normals.at(x, y) = normal;
        view.intensity.at(x, y) = marcher.intensity_at(ray.at(hit->z_m));
      }
    }
  });
  return view;
}

}  // namespace scanknit
