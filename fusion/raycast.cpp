#include "fusion/raycast.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "fusion/luma.h"
#include "fusion/voxel_reader.h"

namespace scanknit {
namespace {

constexpr int kTile = 8;             // pixels a side, for which one range of depth is known
constexpr float kNearest_m = 0.05f;  // no surface is looked for nearer than this
constexpr float kCaution = 0.8f;     // of the distance to the surface is stepped: it was measured from another side

/// In which depths blocks with matter lie, tile by tile, in 64 bins from the camera to the farthest; each block reaches
/// two voxels beyond its samples, so that free space before a surface is seen, too.
class TileDepths {
 public:
  TileDepths(const CameraIntrinsics& k, const Pose& T_world_camera, double voxel_size_m)
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
    std::vector<View> views;
    float farthest_m = kNearest_m;
    for (const BlockIndex::Region& region : index.regions()) {
      if (!view_of(ball_of(region.origin, BlockIndex::kRegionVoxels))) continue;
      for (const BlockIndex::Number number : region.blocks) {
        const VolumeBlock& block = index.blocks()[number];
        if (!block.has_matter || block.is_free) continue;
        const auto view = view_of(ball_of(block.origin, 8));
        if (!view) continue;
        views.push_back(*view);
        farthest_m = std::max(farthest_m, view->far_m);
      }
    }
    bin_m_ = farthest_m / kBins;
    for (const View& view : views) enter(view);
  }

  [[nodiscard]] std::uint64_t at(int x, int y) const { return tiles_.at(x / kTile, y / kTile); }
  [[nodiscard]] float bin_m() const { return bin_m_; }

 private:
  static constexpr int kBins = 64;

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

  /// The tiles and depths that a ball may cover.
  struct View {
    int x0, y0, x1, y1;
    float near_m, far_m;
  };
  [[nodiscard]] std::optional<View> view_of(const Ball& ball) const {
    View view{0,
              0,
              tiles_.width() - 1,
              tiles_.height() - 1,
              ball.centre.z() - ball.radius_m,
              ball.centre.z() + ball.radius_m};
    if (view.far_m < kNearest_m) return std::nullopt;
    if (view.near_m < kNearest_m) {  // reaches behind the camera: it may project anywhere
      view.near_m = kNearest_m;
      return view;
    }
    const bool is_seen = extent(ball.centre.x(), ball.radius_m, view, fx_, cx_, width_, view.x0, view.x1) &&
                         extent(ball.centre.y(), ball.radius_m, view, fy_, cy_, height_, view.y0, view.y1);
    return is_seen ? std::optional(view) : std::nullopt;
  }
  /// Along one axis, by the box round the ball: its sides are seen farthest out at its least or its greatest depth.
  [[nodiscard]] static bool extent(float centre, float radius_m, const View& depths, float focal, float principal,
                                   int size, int& first_tile, int& last_tile) {
    const auto seen_at = [&](float v, float z) { return focal * v / z + principal; };
    const auto [low, high] =
        std::minmax({seen_at(centre - radius_m, depths.near_m), seen_at(centre - radius_m, depths.far_m),
                     seen_at(centre + radius_m, depths.near_m), seen_at(centre + radius_m, depths.far_m)});
    if (!(high >= -1) || !(low <= static_cast<float>(size))) return false;
    const auto tile_of = [&](float pixel) {
      return static_cast<int>(std::clamp(pixel, 0.0f, static_cast<float>(size - 1))) / kTile;
    };
    first_tile = tile_of(low);
    last_tile = tile_of(high + 1);
    return true;
  }

  void enter(const View& view) {
    const auto bin_of = [&](float z_m) { return std::clamp(static_cast<int>(z_m / bin_m_), 0, kBins - 1); };
    const int first = bin_of(view.near_m);
    const int last = bin_of(view.far_m);
    const std::uint64_t bins = (~std::uint64_t{0} >> (kBins - 1 - last)) & (~std::uint64_t{0} << first);
    for (int y = view.y0; y <= view.y1; ++y) {
      for (int x = view.x0; x <= view.x1; ++x) tiles_.at(x, y) |= bins;
    }
  }

  int width_, height_;
  Image<std::uint64_t> tiles_;      ///< bit b: depths from b bin_m_ to (b + 1) bin_m_
  Eigen::Matrix3f R_camera_world_;  ///< and voxels to metres
  Eigen::Vector3f t_camera_world_;
  float fx_, fy_, cx_, cy_;
  float voxel_size_m_;
  float bin_m_ = 1;
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

  /// Through the bins that hold something.
  [[nodiscard]] std::optional<Hit> march(const Ray& ray, std::uint64_t bins, float bin_m) {
    while (bins != 0) {
      const int first = std::countr_zero(bins);
      const int end = first + std::countr_one(bins >> first);
      const Passage passage =
          pass(ray, std::max(static_cast<float>(first) * bin_m, kNearest_m), static_cast<float>(end) * bin_m);
      if (passage.is_over) return passage.hit;
      bins = end < 64 ? bins & (~std::uint64_t{0} << end) : 0;
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
  struct Passage {
    bool is_over = false;  ///< the ray met matter
    std::optional<Hit> hit = {};
  };
  /// From one depth to another.
  [[nodiscard]] Passage pass(const Ray& ray, float z_m, float end_m) {
    constexpr float kUnknown = 0;
    float outside_z_m = kUnknown;  // the last place in free space, if only free space came after it
    while (z_m < end_m) {
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
      if (!(value > 0)) {
        if (outside_z_m == kUnknown) return {true};  // from behind
        return {true, refine(ray, outside_z_m, z_m)};
      }
      outside_z_m = z_m;
      z_m += std::max(kCaution * value * per_voxel_, 0.5f) * ray.voxel_z_m;
    }
    return {};
  }

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
  TileDepths depths(k, T_world_camera, voxel_size_m);
  depths.add(volume.index());
  const Eigen::Vector3f start = (T_world_camera.translation() / voxel_size_m).cast<float>();
  const Eigen::Matrix3f step_of_ray = (T_world_camera.linear() / voxel_size_m).cast<float>();
  const Eigen::Matrix3f R_camera_world = T_world_camera.linear().transpose().cast<float>();

  tbb::parallel_for(0, (k.height + kTile - 1) / kTile, [&](int tile_y) {
    Marcher marcher(volume.index(), static_cast<float>(voxel_size_m));
    for (int y = kTile * tile_y; y < std::min(kTile * (tile_y + 1), k.height); ++y) {
      for (int x = 0; x < k.width; ++x) {
        const std::uint64_t bins = depths.at(x, y);
        if (bins == 0) continue;
        const Eigen::Vector3f along = k.unproject(x, y, 1.0).cast<float>();
        const Ray ray{start, step_of_ray * along, static_cast<float>(voxel_size_m) / along.norm()};
        const auto hit = marcher.march(ray, bins, depths.bin_m());
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
