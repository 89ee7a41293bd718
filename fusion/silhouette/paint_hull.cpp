// paint_hull(), paint_filled(), compare_silhouette(): what the views see of a carved volume.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "fusion/silhouette/fill_gaps.h"
#include "fusion/silhouette/visual_hull.h"
#include "fusion/track/raycast.h"
#include "fusion/volume/block_index.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr int kWidestView_px = 480;  // of what is rendered to see which surface is in front

CameraIntrinsics at_most_as_wide(const CameraIntrinsics& camera, int width) {
  if (camera.width <= width) return camera;
  return camera.resized(width, std::max(1, static_cast<int>(std::lrint(1.0 * camera.height * width / camera.width))));
}

/// The colour at a position, between the pixels; nothing outside of the picture.
std::optional<Eigen::Vector3f> colour_at(const ColourImage& picture, double u, double v) {
  if (!(u >= 0 && v >= 0 && u <= picture.width() - 1 && v <= picture.height() - 1)) return std::nullopt;
  const int x = std::min(static_cast<int>(u), std::max(0, picture.width() - 2));
  const int y = std::min(static_cast<int>(v), std::max(0, picture.height() - 2));
  const auto pixel = [&](int column, int row) {
    const Rgb8& c = picture.at(std::min(column, picture.width() - 1), std::min(row, picture.height() - 1));
    return Eigen::Vector3f(c.r, c.g, c.b);
  };
  const auto right = static_cast<float>(u - x), down = static_cast<float>(v - y);
  const Eigen::Vector3f above = (1 - right) * pixel(x, y) + right * pixel(x + 1, y);
  const Eigen::Vector3f below = (1 - right) * pixel(x, y + 1) + right * pixel(x + 1, y + 1);
  return Eigen::Vector3f((1 - down) * above + down * below);
}

/// A view with the surface that it sees.
class Painter {
 public:
  Painter(const ColourOfView& view, const TsdfVolume& volume)
      : view_(view),
        T_camera_world_(view.T_world_camera.inverse()),
        surface_(raycast(volume, at_most_as_wide(view.camera, kWidestView_px), view.T_world_camera)),
        tolerance_m_(static_cast<float>(3 * volume.config().voxel_size_m)) {}

  struct Stroke {
    Eigen::Vector3f colour;
    float goodness;  ///< cos(incidence)^2 / depth^2
  };
  /// Nothing if the view does not see the point.
  [[nodiscard]] std::optional<Stroke> look(const Vector3d& p) const {
    const Vector3d in_camera = T_camera_world_ * p;
    if (!(in_camera.z() > 0)) return std::nullopt;
    const Eigen::Vector2d at = surface_.intrinsics.project(in_camera);
    if (!(at.x() > -0.5 && at.y() > -0.5 && at.x() < surface_.intrinsics.width - 0.5 &&
          at.y() < surface_.intrinsics.height - 0.5)) {
      return std::nullopt;
    }
    const int x = static_cast<int>(std::lrint(at.x())), y = static_cast<int>(std::lrint(at.y()));
    const float depth = surface_.depth_m.at(x, y);
    const auto z = static_cast<float>(in_camera.z());
    if (!(depth > 0) || z > depth + tolerance_m_) return std::nullopt;
    const float cosine = -surface_.normals.at(x, y).dot(in_camera.normalized().cast<float>());
    if (!(cosine > 0)) return std::nullopt;
    const Eigen::Vector2d pixel = view_.camera.project(in_camera);
    const auto colour = colour_at(*view_.picture, pixel.x(), pixel.y());
    if (!colour) return std::nullopt;
    return Stroke{*colour, cosine * cosine / (z * z)};
  }

 private:
  const ColourOfView& view_;
  Pose T_camera_world_;
  ModelView surface_;
  float tolerance_m_;
};

ColourCode mixed(const std::vector<Painter::Stroke>& strokes) {
  float best = 0;
  for (const Painter::Stroke& stroke : strokes) best = std::max(best, stroke.goodness);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float weights = 0;
  for (const Painter::Stroke& stroke : strokes) {
    const float share = stroke.goodness / best;
    const float weight = share * share * share * share;
    sum += weight * stroke.colour;
    weights += weight;
  }
  const auto channel = [&](int k) { return static_cast<std::uint8_t>(std::lrint(sum[k] / weights)); };
  return encode_colour({channel(0), channel(1), channel(2)}, 255);
}

using Voxels = GapBlock::Voxels;

void paint(const std::vector<Painter>& painters, double voxel_size_m, const Voxels& wanted, VolumeBlock& block) {
  constexpr float kPainted_voxels = 2;  // an edge of a cell that the surface crosses is no longer than the diagonal
  const auto near_m = static_cast<float>(kPainted_voxels * voxel_size_m);
  std::vector<Painter::Stroke> strokes;
  for (unsigned n = 0; n < kBlockVoxels; ++n) {
    if (!wanted[n] || std::abs(block.tsdf->buffer().data()[n]) > near_m) continue;
    const Vector3d p =
        Vector3d(block.origin.x() + static_cast<int>(n >> 6), block.origin.y() + static_cast<int>(n >> 3 & 7),
                 block.origin.z() + static_cast<int>(n & 7)) *
        voxel_size_m;
    strokes.clear();
    for (const Painter& painter : painters) {
      if (const auto stroke = painter.look(p)) strokes.push_back(*stroke);
    }
    if (!strokes.empty()) block.colour->buffer().data()[n] = mixed(strokes);
  }
}

/// A block of the volume, and which of its voxels to paint.
struct PaintTask {
  VolumeBlock* block;
  Voxels voxels;
};

void paint(std::span<const ColourOfView> views, const std::vector<PaintTask>& tasks, TsdfVolume& volume) {
  std::vector<Painter> painters;
  painters.reserve(views.size());
  for (const ColourOfView& view : views) painters.emplace_back(view, volume);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tasks.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      VolumeBlock& block = *tasks[i].block;
      const bool had_colours = has_own_colours(*block.colour);
      paint(painters, volume.config().voxel_size_m, tasks[i].voxels, block);
      if (!had_colours && has_own_colours(*block.colour)) volume.count_colours_of_a_block();
    }
  });
}

}  // namespace

void paint_hull(std::span<const ColourOfView> views, TsdfVolume& volume) {
  std::vector<PaintTask> tasks;
  for (VolumeBlock& block : volume.index().blocks()) {
    PaintTask& task = tasks.emplace_back(PaintTask{&block, {}});
    for (unsigned n = 0; n < kBlockVoxels; ++n) task.voxels[n] = block.tsdf->isValueOn(n);
  }
  paint(views, tasks, volume);
}

void paint_filled(std::span<const ColourOfView> views, const GapFill& fill, TsdfVolume& volume) {
  std::vector<PaintTask> tasks;
  for (const FilledBlock& filled : fill.blocks) {
    const BlockIndex::Number number = volume.index().find(filled.origin);
    tasks.push_back({&volume.index().blocks()[number], filled.voxels});
  }
  paint(views, tasks, volume);
}

SilhouetteFit compare_silhouette(const SilhouetteView& view, const TsdfVolume& volume) {
  const CameraIntrinsics camera = at_most_as_wide(view.camera, kWidestView_px);
  const ModelView seen = raycast(volume, camera, view.T_world_camera);
  double same = 0, both = 0, any = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double u = (x + 0.5) * view.camera.width / camera.width - 0.5;
      const double v = (y + 0.5) * view.camera.height / camera.height - 0.5;
      const bool is_inside = view.silhouette.sees(u, v) && view.silhouette.distance_px(u, v) < 0;
      const bool is_hit = seen.depth_m.at(x, y) > 0;
      same += is_inside == is_hit ? 1 : 0;
      both += is_inside && is_hit ? 1 : 0;
      any += is_inside || is_hit ? 1 : 0;
    }
  }
  return {same / static_cast<double>(seen.depth_m.size()), any > 0 ? both / any : 0};
}

}  // namespace scanknit
