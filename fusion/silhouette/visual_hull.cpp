#include "fusion/silhouette/visual_hull.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fusion/silhouette/hull_cubes.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using openvdb::Coord;

/// The views that can decide the voxels of one block, and their motion into each camera.
class Carver {
 public:
  Carver(std::span<const SilhouetteView> views, const TsdfVolume& volume)
      : views_(views),
        cubes_(views),
        voxel_size_m_(volume.config().voxel_size_m),
        truncation_m_(volume.tsdf().background()) {
    for (const SilhouetteView& view : views) T_camera_world_.push_back(view.T_world_camera.inverse());
  }

  /// The origins of the blocks that the band may meet, in a fixed order; nothing if there are more than `most`.
  [[nodiscard]] std::optional<std::vector<Coord>> band_blocks(const Eigen::AlignedBox3d& box, std::size_t most) const {
    const auto lowest = [&](double m) { return static_cast<int>(std::floor(m / voxel_size_m_ / kBlockEdgeVoxels)); };
    const Coord first(lowest(box.min().x()), lowest(box.min().y()), lowest(box.min().z()));
    const Coord last(lowest(box.max().x()), lowest(box.max().y()), lowest(box.max().z()));
    constexpr int kCubes = 32;  // at first, along the longest side
    const int longest = std::max({last.x() - first.x(), last.y() - first.y(), last.z() - first.z()});
    int edge = 1;  // blocks
    while (longest / edge >= kCubes) edge *= 2;
    std::vector<Coord> cubes;
    for (int x = first.x(); x <= last.x(); x += edge) {
      for (int y = first.y(); y <= last.y(); y += edge) {
        for (int z = first.z(); z <= last.z(); z += edge) cubes.emplace_back(x, y, z);
      }
    }
    for (;; edge /= 2) {
      cubes = those_in_the_band(cubes, edge);
      if (cubes.size() > most) return std::nullopt;
      if (edge == 1) break;
      cubes = halves_of(cubes, edge / 2, last);
    }
    for (Coord& cube : cubes) cube = Coord(cube.x() << 3, cube.y() << 3, cube.z() << 3);
    return cubes;
  }

  /// False if the band does not meet the block.
  [[nodiscard]] bool carve(NewBlock& block) const {
    const Vector3d origin = position(block.block.origin);
    const std::vector<std::size_t> deciding = deciding_views(origin);
    float* tsdf = block.tsdf->buffer().data();
    WeightCode* weight = block.weight->buffer().data();
    TsdfLeaf::NodeMaskType known;
    bool is_in_band = false, is_free = true;
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      const Vector3d p = origin + Vector3d(n >> 6, n >> 3 & 7, n & 7) * voxel_size_m_;
      const auto [distance_m, seen_by] = look(p, deciding);
      if (seen_by < kFewestSilhouettes) continue;
      known.setOn(n);
      tsdf[n] = distance_m;
      weight[n] = encode_weight(static_cast<float>(seen_by));
      is_in_band = is_in_band || std::abs(distance_m) < truncation_m_;
      is_free = is_free && distance_m >= truncation_m_;
      block.block.has_matter = block.block.has_matter || distance_m < 0;
    }
    block.block.is_free = is_free && known.isOn();
    block.tsdf->setValueMask(known);
    block.weight->setValueMask(known);
    block.colour->setValueMask(known);
    return is_in_band;
  }

 private:
  struct Look {
    float distance_m = 0;
    int seen_by = 0;
  };

  [[nodiscard]] Vector3d position(const Coord& index) const {
    return Vector3d(index.x(), index.y(), index.z()) * voxel_size_m_;
  }

  [[nodiscard]] std::vector<Coord> those_in_the_band(const std::vector<Coord>& cubes, int edge) const {
    std::vector<char> keeps(cubes.size());
    const double half_m = edge * kBlockEdgeVoxels * voxel_size_m_ / 2;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cubes.size()), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        const Vector3d origin = position(Coord(cubes[i].x() << 3, cubes[i].y() << 3, cubes[i].z() << 3));
        keeps[i] = cubes_.may_hold_surface(origin + Vector3d::Constant(half_m), half_m, truncation_m_) ? 1 : 0;
      }
    });
    std::vector<Coord> kept;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      if (keeps[i] != 0) kept.push_back(cubes[i]);
    }
    return kept;
  }

  static std::vector<Coord> halves_of(const std::vector<Coord>& cubes, int edge, const Coord& last) {
    std::vector<Coord> halves;
    for (const Coord& cube : cubes) {
      for (int k = 0; k < 8; ++k) {
        const Coord half = cube + Coord((k >> 2 & 1) * edge, (k >> 1 & 1) * edge, (k & 1) * edge);
        if (half.x() <= last.x() && half.y() <= last.y() && half.z() <= last.z()) halves.push_back(half);
      }
    }
    return halves;
  }

  /// Those in which the block is not as a whole so far within the silhouette that it is not in the band.
  [[nodiscard]] std::vector<std::size_t> deciding_views(const Vector3d& origin) const {
    const double half_m = kBlockEdgeVoxels * voxel_size_m_ / 2;
    std::vector<std::size_t> deciding;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      if (!cubes_.is_deep_inside(i, origin + Vector3d::Constant(half_m), half_m, truncation_m_)) deciding.push_back(i);
    }
    return deciding;
  }

  /// The views that do not decide see the voxel, deep inside.
  [[nodiscard]] Look look(const Vector3d& p, const std::vector<std::size_t>& deciding) const {
    Look look{-truncation_m_, static_cast<int>(views_.size() - deciding.size())};
    for (const std::size_t i : deciding) {
      const Vector3d in_camera = T_camera_world_[i] * p;
      if (!(in_camera.z() > 0)) continue;
      const Eigen::Vector2d pixel = views_[i].camera.project(in_camera);
      if (!views_[i].silhouette.sees(pixel.x(), pixel.y())) continue;
      ++look.seen_by;
      const double metres_per_pixel = in_camera.z() / focal_length(views_[i].camera);
      const double distance = views_[i].silhouette.distance_px(pixel.x(), pixel.y()) * metres_per_pixel;
      look.distance_m = std::max(look.distance_m, static_cast<float>(std::min<double>(distance, truncation_m_)));
    }
    return look;
  }

  std::span<const SilhouetteView> views_;
  HullCubes cubes_;
  double voxel_size_m_;
  float truncation_m_;
  std::vector<Pose> T_camera_world_;
};

}  // namespace

Result<CarveStats> carve_hull(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& box,
                              TsdfVolume& volume) {
  try {
    constexpr double kFarthest = 1e9;  // voxels; indices must fit their type, with room to spare
    if (!(box.min().cwiseAbs().maxCoeff() / volume.config().voxel_size_m < kFarthest) ||
        !(box.max().cwiseAbs().maxCoeff() / volume.config().voxel_size_m < kFarthest)) {
      return Error{ErrorCode::kInput, "the thing is too far from the world's origin for this voxel size"};
    }
    const Carver carver(views, volume);
    CarveStats stats;
    constexpr std::size_t kBytesPerBlock = kBlockVoxels * (sizeof(float) + sizeof(WeightCode) + sizeof(ColourCode));
    constexpr std::size_t kTimesTheBudget = 4;  // cubes and blocks that only may meet the band are among them
    const std::size_t room = (volume.config().memory_budget_mib << 20) / kBytesPerBlock;
    auto found = carver.band_blocks(box, kTimesTheBudget * room);
    if (!found) {
      return Error{ErrorCode::kBudget,
                   "the hull needs far more memory than fusion.memory_budget: set a larger fusion.voxel_size"};
    }
    std::vector<Coord> wanted = *std::move(found);
    BlockBudget budget = volume.block_budget();
    std::erase_if(wanted, [&](const Coord& origin) { return !budget.admits(origin); });
    stats.is_budget_reached = budget.is_reached();
    std::vector<NewBlock> fresh(wanted.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, wanted.size()), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        NewBlock made(wanted[i], volume.tsdf().background());
        if (carver.carve(made)) fresh[i] = std::move(made);
      }
    });
    ++volume.frames;
    for (NewBlock& made : fresh) {
      if (!made.has_leaves()) continue;
      made.block.last_frame = volume.frames;
      made.block.has_changed = true;
      volume.add_block(std::move(made));
      ++stats.blocks_added;
    }
    volume.is_budget_reached = volume.is_budget_reached || stats.is_budget_reached;
    return stats;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while carving; a larger fusion.voxel_size needs less"};
  } catch (const openvdb::Exception& e) {
    return Error{ErrorCode::kInternal, std::string("OpenVDB: ") + e.what()};
  }
}

}  // namespace scanknit
