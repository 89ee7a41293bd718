#include "fusion/range/range_integrate.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#include "fusion/integrate/surface_rows.h"
#include "fusion/integrate/update_block.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using openvdb::Coord;

constexpr int kLastInBlock = kBlockEdgeVoxels - 1;
constexpr int kRowsPerTask = 16;

Coord block_of(const Vector3d& index) {
  const auto lowest = [](double v) { return static_cast<int>(std::floor(v)) & ~kLastInBlock; };
  return {lowest(index.x()), lowest(index.y()), lowest(index.z())};
}

/// How one scan updates blocks.
class RangeUpdate {
 public:
  RangeUpdate(const RangeView& view, double noise_m, const Pose& T_world_scan, TsdfVolume& volume)
      : view_(view),
        T_world_scan_(T_world_scan),
        T_scan_world_(T_world_scan.inverse()),
        voxel_size_m_(volume.config().voxel_size_m),
        truncation_m_(static_cast<float>(
            std::max(volume.config().truncation_voxels * voxel_size_m_, volume.config().truncation_sigmas * noise_m))),
        volume_(volume) {
    nearest_m_ = std::numeric_limits<float>::max();
    for (const RangeView::Pixel& pixel : view.pixels().pixels()) {
      if (pixel.slope > 0) nearest_m_ = std::min(nearest_m_, pixel.range_m);
    }
  }

  /// Voxel indices must fit their type, with room to spare.
  [[nodiscard]] bool is_indexable() const {
    double farthest_m = 0;
    for (const RangeView::Pixel& pixel : view_.pixels().pixels()) {
      if (!(pixel.slope > 0)) continue;
      farthest_m = std::max(farthest_m, (T_world_scan_ * pixel.point.cast<double>()).cwiseAbs().maxCoeff());
    }
    return farthest_m / voxel_size_m_ < std::numeric_limits<int>::max() / 4;
  }

  /// The blocks that the band meets, sorted, each once.
  [[nodiscard]] std::vector<Coord> band_blocks() const {
    const int tasks = (view_.pixels().height() + kRowsPerTask - 1) / kRowsPerTask;
    std::vector<std::vector<Coord>> found(static_cast<std::size_t>(tasks));
    tbb::parallel_for(0, tasks, [&](int task) {
      std::vector<Coord>& own = found[static_cast<std::size_t>(task)];
      const int end = std::min((task + 1) * kRowsPerTask, view_.pixels().height());
      for (int y = task * kRowsPerTask; y < end; ++y) add_row(y, own);
      sort_unique(own);
    });
    std::vector<Coord> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    sort_unique(all);
    return all;
  }

  /// False where the block lies farther away than the scan's band reaches: apply() would change nothing.
  [[nodiscard]] bool may_reach(const Coord& origin) const {
    if (view_.sight().kind != SightLines::Kind::kSphere) return true;
    const Vector3d middle = Vector3d(origin.x(), origin.y(), origin.z()).array() + 0.5 * kLastInBlock;
    const double off = (T_scan_world_ * (middle * voxel_size_m_) - view_.sight().centre).norm();
    const double half_block = std::sqrt(3.0) / 2 * kLastInBlock * voxel_size_m_;
    return off <= view_.farthest_m() + truncation_m_ / kMinBandSlope + half_block + voxel_size_m_;
  }

  /// True if the scan said something of it.
  bool apply(VolumeBlock& block) const {
    TsdfLeaf::NodeMaskType observed = block.tsdf->getValueMask();
    bool has_changed = false;
    bool is_free = true;
    const Vector3d first =
        T_scan_world_ * (Vector3d(block.origin.x(), block.origin.y(), block.origin.z()) * voxel_size_m_);
    const Eigen::Matrix3d step = T_scan_world_.linear() * voxel_size_m_;
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      const Vector3d p = first + step * Vector3d(n >> 6, n >> 3 & 7, n & 7);
      if (!update(p, block, n)) continue;
      has_changed = true;
      observed.setOn(n);
      const float distance = block.tsdf->buffer().data()[n];
      is_free = is_free && distance >= volume_.tsdf().background();
      block.has_matter = block.has_matter || distance < 0;
    }
    if (!has_changed) return false;
    block.is_free = is_free && observed.isOn();
    block.tsdf->setValueMask(observed);
    block.weight->setValueMask(observed);
    block.colour->setValueMask(observed);
    return true;
  }

 private:
  static void sort_unique(std::vector<Coord>& blocks) {
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  }

  /// Along the line, as far as the band reaches at the pixel's slope, and half the way to the next lines.
  void add_row(int y, std::vector<Coord>& blocks) const {
    for (const RangeView::Pixel& pixel : view_.pixels().row(y)) {
      if (!(pixel.slope > 0)) continue;
      const Vector3d p = pixel.point.cast<double>();
      const double reach = truncation_m_ / std::max(pixel.slope, kMinBandSlope);
      const Vector3d along = T_world_scan_.linear() * view_.sight().direction(p) / voxel_size_m_;
      const Vector3d middle = T_world_scan_ * p / voxel_size_m_;
      const int steps = static_cast<int>(std::ceil(2 * reach / (voxel_size_m_ * kLastInBlock)));
      for (int s = 0; s <= steps; ++s) {
        const Vector3d at = middle + along * (reach * (2.0 * s / steps - 1));
        constexpr double kBeside = 2;  // voxels; lines are about a voxel apart, or the grid is too coarse for them
        for (int corner = 0; corner < 8; ++corner) {
          const Vector3d off((corner & 1) != 0 ? kBeside : -kBeside, (corner & 2) != 0 ? kBeside : -kBeside,
                             (corner & 4) != 0 ? kBeside : -kBeside);
          const Coord block = block_of(at + off);
          if (blocks.empty() || blocks.back() != block) blocks.push_back(block);
        }
      }
    }
  }

  /// As update_block() weighs: nearness cubed on both sides, and kFreeSpaceShare in front.
  [[nodiscard]] bool update(const Vector3d& p, VolumeBlock& block, unsigned n) const {
    const auto front = view_.front_of(p);
    if (!front) return false;
    const float distance = front->distance_m;
    if (distance < -truncation_m_ || front->before_m * kMinBandSlope < -truncation_m_) return false;
    const float inside = std::max(0.0f, 1 - std::abs(distance) / truncation_m_);
    const float nearness = inside * inside * inside;
    const float share = distance >= 0 ? std::max(nearness, kFreeSpaceShare) : nearness;
    const float weight = confidence(*front->pixel) * share;
    if (!(weight > 0)) return false;

    float& mean = block.tsdf->buffer().data()[n];
    WeightCode& code = block.weight->buffer().data()[n];
    const float before = decode_weight(code);
    const float sum = before + weight;
    mean += (std::min(distance, truncation_m_) - mean) * (weight / sum);
    code = encode_weight(std::min(sum, static_cast<float>(volume_.config().max_weight)));
    if (front->pixel->colour != 0 && std::abs(distance) < kInnerBand * truncation_m_)
      paint(*front->pixel, block.colour->buffer().data()[n]);
    return true;
  }

  [[nodiscard]] float confidence(const RangeView::Pixel& pixel) const {
    const float weight = pixel.slope * pixel.inset;
    if (view_.sight().kind != SightLines::Kind::kSphere) return weight;
    const float nearness = nearest_m_ / pixel.range_m;
    return weight * nearness * nearness;
  }

  /// The mean of the views about as good as the best one.
  static void paint(const RangeView::Pixel& pixel, ColourCode& code) {
    const float goodness = pixel.slope * pixel.slope * pixel.inset;
    const float best = static_cast<float>(code >> 24) / 255;
    const float good = goodness * goodness;
    const float others = (kColourViews - 1) * (best * best) * (best * best);
    const float share = has_colour(code) ? good / (good + others) : 1;
    const Rgb8 now = decode_colour(pixel.colour);
    const Rgb8 old = decode_colour(code);
    const auto mixed = [&](std::uint8_t a, std::uint8_t b) {
      const float value = static_cast<float>(a) + (static_cast<float>(b) - static_cast<float>(a)) * share;
      return static_cast<std::uint8_t>(std::lrint(std::clamp(value, 0.0f, 255.0f)));
    };
    const float quality = std::clamp(std::max(best, std::sqrt(goodness)) * 255, 1.0f, 255.0f);
    code = encode_colour({mixed(old.r, now.r), mixed(old.g, now.g), mixed(old.b, now.b)},
                         static_cast<std::uint8_t>(std::lrint(quality)));
  }

  const RangeView& view_;
  Pose T_world_scan_, T_scan_world_;
  double voxel_size_m_;
  float truncation_m_;
  float nearest_m_;
  TsdfVolume& volume_;
};

void update_blocks(const RangeUpdate& update, TsdfVolume& volume, IntegrateStats& stats) {
  std::vector<Coord> wanted;
  std::vector<BlockIndex::Number> known;
  BlockBudget budget = volume.block_budget();
  for (const Coord& origin : update.band_blocks()) {
    const BlockIndex::Number number = volume.index().find(origin);
    if (number != BlockIndex::kNone) {
      known.push_back(number);
    } else if (budget.admits(origin)) {
      wanted.push_back(origin);
    }
  }
  stats.is_budget_reached = budget.is_reached();
  stats.blocks_touched = known.size() + wanted.size();
  if (volume.config().carve_free_space) {  // what lies before the surface, too
    known.clear();
    for (std::size_t i = 0; i < volume.blocks(); ++i) {
      if (update.may_reach(volume.index().blocks()[i].origin)) known.push_back(static_cast<BlockIndex::Number>(i));
    }
  }
  std::vector<NewBlock> fresh(wanted.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, known.size() + wanted.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      if (i < known.size()) {
        VolumeBlock& block = volume.index().blocks()[known[i]];
        if (!update.apply(block)) continue;
        block.has_changed = true;
        block.last_frame = volume.frames;
        continue;
      }
      NewBlock made(wanted[i - known.size()], volume.tsdf().background());
      made.colour->allocate();
      if (update.apply(made.block)) fresh[i - known.size()] = std::move(made);
    }
  });
  for (NewBlock& made : fresh) {
    if (!made.has_leaves()) continue;
    made.block.last_frame = volume.frames;
    made.block.has_changed = true;
    volume.add_block(std::move(made));
    ++stats.blocks_added;
  }
}

}  // namespace

Result<IntegrateStats> integrate(const RangeView& view, double noise_m, const Pose& T_world_scan, TsdfVolume& volume) {
  if (!is_rigid(T_world_scan)) return Error{ErrorCode::kInput, "the pose is not a rigid motion"};
  try {
    const RangeUpdate update(view, noise_m, T_world_scan, volume);
    if (!update.is_indexable()) {
      return Error{ErrorCode::kInput, "the pose is too far from the world's origin for this voxel size"};
    }
    ++volume.frames;
    IntegrateStats stats;
    update_blocks(update, volume, stats);
    volume.is_budget_reached = volume.is_budget_reached || stats.is_budget_reached;
    return stats;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while integrating a scan; a larger fusion.voxel_size needs less"};
  } catch (const openvdb::Exception& e) {
    return Error{ErrorCode::kInternal, std::string("OpenVDB: ") + e.what()};
  }
}

}  // namespace scanknit
