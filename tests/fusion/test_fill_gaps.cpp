// A visual hull fills what depth left.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "analytic_frames.h"
#include "fusion/integrate/integrate.h"
#include "fusion/silhouette/depth_gaps.h"
#include "fusion/silhouette/fill_gaps.h"
#include "fusion/silhouette/visual_hull.h"
#include "fusion/volume/block_index.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using openvdb::Coord;

constexpr double kGapVoxel_m = 0.004;
constexpr double kBall_m = 0.1;
constexpr double kDarkFrom_m = 0.05;  // of the ball: the cap beyond it, along x, gives no depth
constexpr double kAway_m = 0.6;

CameraIntrinsics gap_camera() {
  return {320, 320, 300, 300, 159.5, 159.5};
}

/// Round the z axis, from above and from below in turn.
std::vector<Pose> poses_round_ball(int count) {
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    const double up = i % 2 == 0 ? 0.9 : -0.6;
    poses.push_back(test::looking_at_origin(
        kAway_m * Vector3d(std::cos(angle) * std::cos(up), std::sin(angle) * std::cos(up), std::sin(up))));
  }
  return poses;
}

Frame ball_frame(const Pose& T_world_camera, double radius_m) {
  return test::sphere_frame(gap_camera(), T_world_camera.inverse().translation(), radius_m);
}

/// The ball, without depth of the dark cap.
Frame half_dark_frame(const Pose& T_world_camera) {
  Frame frame = ball_frame(T_world_camera, kBall_m);
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = 0; x < frame.depth_m.width(); ++x) {
      const Vector3d p = T_world_camera * frame.intrinsics.unproject(x, y, double{frame.depth_m.at(x, y)});
      if (frame.depth_m.at(x, y) > 0 && p.x() > kDarkFrom_m) frame.depth_m.at(x, y) = 0;
    }
  }
  return frame;
}

std::vector<SilhouetteView> ball_views(const std::vector<Pose>& poses) {
  std::vector<SilhouetteView> views;
  for (const Pose& pose : poses) {
    const Frame frame = ball_frame(pose, kBall_m);
    Image<std::uint8_t> mask(frame.depth_m.width(), frame.depth_m.height());
    for (std::size_t i = 0; i < mask.size(); ++i) mask.pixels()[i] = frame.depth_m.pixels()[i] > 0 ? 255 : 0;
    views.push_back({frame.intrinsics, pose, Silhouette(mask, 16)});
  }
  return views;
}

TsdfVolume volume_of(std::size_t budget_mib = FusionConfig().memory_budget_mib) {
  FusionConfig config;
  config.voxel_size_m = kGapVoxel_m;
  config.memory_budget_mib = budget_mib;
  return *TsdfVolume::create(config);
}

/// Where the hull is.
Eigen::AlignedBox3d box_of(const std::vector<SilhouetteView>& views) {
  const auto box = hull_box(views);
  EXPECT_TRUE(box) << box.error().text();
  return box ? *box : Eigen::AlignedBox3d();
}

/// The views, the frames, and the volume that these make.
struct HalfDarkBall {
  std::vector<Pose> poses = poses_round_ball(16);
  std::vector<SilhouetteView> views = ball_views(poses);
  TsdfVolume volume = volume_of();

  HalfDarkBall() {
    for (const Pose& pose : poses) EXPECT_TRUE(integrate(half_dark_frame(pose), pose, volume));
  }
  [[nodiscard]] DepthGaps gaps(const DepthGaps::MayFill& may_fill = {}) const {
    auto found = DepthGaps::find(views, box_of(views), volume, may_fill);
    EXPECT_TRUE(found) << found.error().text();
    for (const Pose& pose : poses) found->look_through(half_dark_frame(pose).depth_m, gap_camera(), pose);
    return *std::move(found);
  }
};

struct Known {
  float tsdf_m;
  WeightCode weight;
  friend bool operator==(const Known&, const Known&) = default;
};

std::map<Coord, Known> known_voxels(const TsdfVolume& volume) {
  std::map<Coord, Known> known;
  for (const VolumeBlock& block : volume.index().blocks()) {
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      const WeightCode weight = block.weight->buffer().data()[n];
      if (weight == 0) continue;
      EXPECT_TRUE(block.tsdf->isValueOn(n) && block.weight->isValueOn(n) && block.colour->isValueOn(n));
      known[block.tsdf->offsetToGlobalCoord(n)] = {block.tsdf->buffer().data()[n], weight};
    }
  }
  return known;
}

Coord voxel_at(const Vector3d& p) {
  const auto index = [&](int axis) { return static_cast<int>(std::lround(p[axis] / kGapVoxel_m)); };
  return {index(0), index(1), index(2)};
}

TEST(FillGaps, NeverChangesWhatDepthDecided) {
  HalfDarkBall ball;
  const auto before = known_voxels(ball.volume);
  const auto fill = fill_gaps(ball.gaps(), ball.volume);
  ASSERT_TRUE(fill) << fill.error().text();
  EXPECT_GT(fill->voxels_inside, 1000u);
  const auto after = known_voxels(ball.volume);
  std::size_t filled = 0;
  for (const FilledBlock& block : fill->blocks) filled += block.voxels.count();
  EXPECT_EQ(after.size(), before.size() + filled);
  for (const auto& [index, voxel] : before) ASSERT_TRUE(after.at(index) == voxel) << index;
}

TEST(FillGaps, GivesTheHullsDistance) {
  HalfDarkBall ball;
  TsdfVolume hull = volume_of();
  ASSERT_TRUE(carve_hull(ball.views, box_of(ball.views), hull));
  const auto of_hull = known_voxels(hull), before = known_voxels(ball.volume);
  const auto fill = fill_gaps(ball.gaps(), ball.volume);
  ASSERT_TRUE(fill) << fill.error().text();
  const auto after = known_voxels(ball.volume);
  for (const auto& [index, voxel] : after) {
    if (before.contains(index)) continue;
    ASSERT_TRUE(of_hull.contains(index)) << index;
    ASSERT_TRUE(of_hull.at(index) == voxel) << index;
  }
  for (const double aside : {-0.03, 0.0, 0.03}) {
    const Vector3d direction = Vector3d(0.1, aside, 0.02).normalized();
    EXPECT_FALSE(before.contains(voxel_at(kBall_m * direction))) << "depth does not know the cap";
    const auto within = after.find(voxel_at((kBall_m - 2 * kGapVoxel_m) * direction));
    const auto beyond = after.find(voxel_at((kBall_m + 2 * kGapVoxel_m) * direction));
    ASSERT_TRUE(within != after.end());
    EXPECT_LT(within->second.tsdf_m, 0);
    EXPECT_TRUE(beyond == after.end() || beyond->second.tsdf_m > 0);
  }
}

/// The whole cap, but for where the hull is larger than the ball.
TEST(FillGaps, ClosesTheSurface) {
  HalfDarkBall ball;
  ASSERT_TRUE(fill_gaps(ball.gaps(), ball.volume));
  const auto after = known_voxels(ball.volume);
  for (const auto& [index, voxel] : after) {
    if (voxel.tsdf_m >= 0 || (index.asVec3d() * kGapVoxel_m).x() < kDarkFrom_m + 4 * kGapVoxel_m) continue;
    for (int k = 0; k < 27; ++k) {
      ASSERT_TRUE(after.contains(index.offsetBy(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1)) ||
                  index.asVec3d().length() * kGapVoxel_m < kBall_m - 2 * kGapVoxel_m)
          << index;
    }
  }
}

TEST(FillGaps, LeavesOutWhatAFrameLooksThrough) {
  const std::vector<Pose> poses = poses_round_ball(16);
  const std::vector<SilhouetteView> views = ball_views(poses);
  constexpr double kSmaller_m = 0.06;  // what depth sees within the silhouettes
  TsdfVolume volume = volume_of();
  for (const Pose& pose : poses) ASSERT_TRUE(integrate(ball_frame(pose, kSmaller_m), pose, volume));
  const auto before = known_voxels(volume);
  auto gaps = DepthGaps::find(views, box_of(views), volume);
  ASSERT_TRUE(gaps) << gaps.error().text();
  const std::size_t all = gaps->voxels_inside();
  for (const Pose& pose : poses) gaps->look_through(ball_frame(pose, kSmaller_m).depth_m, gap_camera(), pose);
  EXPECT_LT(gaps->voxels_inside(), all);
  ASSERT_TRUE(fill_gaps(*gaps, volume));
  const auto after = known_voxels(volume);
  for (const Pose& pose : poses) {
    const Coord before_it = voxel_at(0.09 * pose.translation().normalized());
    const auto known = after.find(before_it);
    EXPECT_EQ(known != after.end(), before.contains(before_it)) << "the camera sees the smaller ball behind it";
    EXPECT_TRUE(known == after.end() || known->second.tsdf_m > 0) << before_it;
  }
}

TEST(FillGaps, StaysWhereItMayFill) {
  HalfDarkBall ball;
  const auto before = known_voxels(ball.volume);
  const auto fill = fill_gaps(ball.gaps([](const Vector3d& p) { return p.z() > 0; }), ball.volume);
  ASSERT_TRUE(fill);
  EXPECT_GT(fill->voxels_inside, 100u);
  for (const auto& [index, voxel] : known_voxels(ball.volume)) {
    ASSERT_TRUE(before.contains(index) || index.z() > 0) << index;
  }
}

TEST(FillGaps, SaysWhenTheBudgetIsReached) {
  const std::vector<SilhouetteView> views = ball_views(poses_round_ball(16));
  TsdfVolume volume = volume_of(kLeastMemoryBudgetMib);
  const auto gaps = DepthGaps::find(views, box_of(views), volume);
  ASSERT_TRUE(gaps) << gaps.error().text();
  const auto fill = fill_gaps(*gaps, volume);
  ASSERT_TRUE(fill);
  EXPECT_TRUE(fill->is_budget_reached);
  EXPECT_TRUE(volume.is_budget_reached);
  EXPECT_LT(fill->blocks.size(), gaps->blocks().size());
}

TEST(FillGaps, PaintsWhatItFilled) {
  HalfDarkBall ball;
  const auto fill = fill_gaps(ball.gaps(), ball.volume);
  ASSERT_TRUE(fill);
  const ColourImage red(gap_camera().width, gap_camera().height, Rgb8{200, 10, 10});
  std::vector<ColourOfView> colours;
  for (const SilhouetteView& view : ball.views) colours.push_back({&red, view.camera, view.T_world_camera});
  paint_filled(colours, *fill, ball.volume);
  std::map<Coord, const FilledBlock*> filled;
  for (const FilledBlock& block : fill->blocks) filled[block.origin] = &block;
  std::size_t painted = 0;
  for (const VolumeBlock& block : ball.volume.index().blocks()) {
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      if (!has_colour(colours_of(*block.colour)[n])) continue;
      ++painted;
      ASSERT_TRUE(filled.contains(block.origin) && filled[block.origin]->voxels[n]);
    }
  }
  EXPECT_GT(painted, 500u);
}

TEST(FillGaps, IsTheSameForAnyNumberOfThreads) {
  const auto filled_by = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    HalfDarkBall ball;
    EXPECT_TRUE(fill_gaps(ball.gaps(), ball.volume));
    return known_voxels(ball.volume);
  };
  EXPECT_TRUE(filled_by(1) == filled_by(4));
}

}  // namespace
}  // namespace scanknit
