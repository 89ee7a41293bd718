#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <limits>
#include <random>
#include <set>

#include "fusion/integrate/band_blocks.h"
#include "fusion/integrate/block_counter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/integrate/update_block.h"
#include "tests/fusion/analytic_frames.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using test::looking_at_origin;
using test::plane_frame;
using test::small_camera;
using test::sphere_frame;

constexpr double kVoxel = 0.01;
constexpr float kFloatNoise = 1e-5f;  // rounding of metres of a few units in float

FusionConfig fixed_band() {
  FusionConfig config;
  config.voxel_size_m = kVoxel;
  config.truncation_voxels = 4;
  config.truncation_sigmas = 0;
  return config;
}

TsdfVolume make_volume(const FusionConfig& config) {
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  return std::move(volume).value();
}

/// Calls visit(coord, tsdf) for every observed voxel.
template <typename Visit>
void for_each_observed(const TsdfVolume& volume, Visit visit) {
  for (auto voxel = volume.tsdf().cbeginValueOn(); voxel; ++voxel) visit(voxel.getCoord(), *voxel);
}

bool are_equal(const TsdfVolume& a, const TsdfVolume& b) {
  if (a.active_voxels() != b.active_voxels() || a.blocks() != b.blocks()) return false;
  const auto tsdf = b.tsdf().getConstAccessor();
  const auto weight = b.weight().getConstAccessor();
  const auto weight_a = a.weight().getConstAccessor();
  const auto colour = b.colour().getConstAccessor();
  const auto colour_a = a.colour().getConstAccessor();
  bool equal = true;
  for_each_observed(a, [&](const Coord& c, float value) {
    equal = equal && tsdf.isValueOn(c) && tsdf.getValue(c) == value && weight.getValue(c) == weight_a.getValue(c) &&
            colour.getValue(c) == colour_a.getValue(c);
  });
  return equal;
}

TEST(Integrate, GivesTheExactDistanceToASlantedPlane) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  const double offset_m = -0.8;
  TsdfVolume volume = make_volume(fixed_band());
  ASSERT_TRUE(integrate(plane_frame(small_camera(), normal, offset_m), Pose::Identity(), volume));
  ASSERT_GT(volume.active_voxels(), 10000u);
  const float band_m = static_cast<float>(4 * kVoxel);
  for_each_observed(volume, [&](const Coord& c, float value) {
    const Eigen::Vector3d p = Eigen::Vector3d(c.x(), c.y(), c.z()) * kVoxel;
    const auto truth = static_cast<float>(normal.dot(p) - offset_m);
    ASSERT_NEAR(value, std::min(truth, band_m), kFloatNoise) << c;
  });
}

TEST(Integrate, GivesTheExactDistanceWhereEveryThirdPixelIsMissing) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  Frame frame = plane_frame(small_camera(), normal, -0.8);
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = y % 3; x < frame.depth_m.width(); x += 3) frame.depth_m.at(x, y) = 0;
  }
  TsdfVolume volume = make_volume(fixed_band());
  ASSERT_TRUE(integrate(frame, Pose::Identity(), volume));
  ASSERT_GT(volume.active_voxels(), 10000u);
  for_each_observed(volume, [&](const Coord& c, float value) {
    const Eigen::Vector3d p = Eigen::Vector3d(c.x(), c.y(), c.z()) * kVoxel;
    ASSERT_NEAR(value, std::min(static_cast<float>(normal.dot(p) + 0.8), static_cast<float>(4 * kVoxel)), kFloatNoise);
  });
}

TEST(Integrate, LeavesHiddenSpaceUnknown) {
  TsdfVolume volume = make_volume(fixed_band());
  ASSERT_TRUE(integrate(plane_frame(small_camera(), {0, 0, -1}, -0.8), Pose::Identity(), volume));
  EXPECT_GT(volume.voxel({0, 0, 80}).weight, 0);  // on the surface
  EXPECT_GT(volume.voxel({0, 0, 77}).weight, 0);  // in front
  EXPECT_GT(volume.voxel({0, 0, 83}).weight, 0);  // within the band behind
  EXPECT_EQ(volume.voxel({0, 0, 85}).weight, 0);  // beyond the band: never seen
  EXPECT_FALSE(volume.weight().tree().isValueOn({0, 0, 85}));
}

TEST(Integrate, MarksSpaceInFrontAsFree) {
  TsdfVolume volume = make_volume(fixed_band());
  const Frame wall_at_80 = plane_frame(small_camera(), {0, 0, -1}, -0.8);
  const Frame wall_at_100 = plane_frame(small_camera(), {0, 0, -1}, -1.0);
  ASSERT_TRUE(integrate(wall_at_80, Pose::Identity(), volume));
  const float before_m = volume.voxel({0, 0, 82}).tsdf_m;
  EXPECT_LT(before_m, 0);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(integrate(wall_at_100, Pose::Identity(), volume));
  EXPECT_GT(volume.voxel({0, 0, 82}).tsdf_m, 0);  // the wall that went away is carved
}

TEST(Integrate, LeavesKnownSpaceAloneWithoutCarving) {
  FusionConfig config = fixed_band();
  config.carve_free_space = false;
  TsdfVolume volume = make_volume(config);
  ASSERT_TRUE(integrate(plane_frame(small_camera(), {0, 0, -1}, -0.8), Pose::Identity(), volume));
  const float before_m = volume.voxel({0, 0, 82}).tsdf_m;
  ASSERT_TRUE(integrate(plane_frame(small_camera(), {0, 0, -1}, -1.6), Pose::Identity(), volume));
  EXPECT_EQ(volume.voxel({0, 0, 82}).tsdf_m, before_m);
}

TEST(Integrate, WeighsHeadOnViewsByTheNoiseOfTheirRange) {
  FusionConfig config = fixed_band();
  TsdfVolume volume = make_volume(config);
  ASSERT_TRUE(integrate(plane_frame(small_camera(), {0, 0, -1}, -2.0), Pose::Identity(), volume));
  const double sigma_ratio = config.noise.sigma_m(config.noise.from_m) / config.noise.sigma_m(2.0);
  const float weight = volume.voxel({0, 0, 200}).weight;
  const double kOffAxisPixel = 0.001;  // cosine of the pixel next to the principal point
  EXPECT_NEAR(static_cast<double>(weight), sigma_ratio * sigma_ratio, kOffAxisPixel);
}

TEST(Integrate, WidensTheBandWithTheNoise) {
  FusionConfig config = fixed_band();
  config.truncation_sigmas = 10;
  TsdfVolume volume = make_volume(config);
  ASSERT_TRUE(integrate(plane_frame(small_camera(), {0, 0, -1}, -2.0), Pose::Identity(), volume));
  const double band_m = 10 * config.noise.sigma_m(2.0);
  const int voxels = static_cast<int>(band_m / kVoxel);
  ASSERT_GT(voxels, 4);
  EXPECT_GT(volume.voxel({0, 0, 200 + voxels}).weight, 0);
  EXPECT_EQ(volume.voxel({0, 0, 200 + voxels + 1}).weight, 0);
}

/// A wall that the camera sees from `range_m` in one colour; it stands at z = 0.8 m in the world.
void see_wall(TsdfVolume& volume, double range_m, const Rgb8& colour) {
  Frame frame = plane_frame(small_camera(), {0, 0, -1}, -range_m);
  frame.colour = ColourFrame{ColourImage(160, 120, colour), small_camera(), Pose::Identity()};
  ASSERT_TRUE(integrate(frame, Pose(Eigen::Translation3d(0, 0, 0.8 - range_m)), volume));
}

Rgb8 wall_colour(const TsdfVolume& volume) {
  return volume.voxel({0, 0, 80}).colour.value_or(Rgb8{1, 2, 3});
}

TEST(Integrate, TakesTheColourOfTheFirstView) {
  TsdfVolume volume = make_volume(fixed_band());
  see_wall(volume, 0.8, {200, 100, 0});
  EXPECT_EQ(wall_colour(volume), (Rgb8{200, 100, 0}));
}

TEST(Integrate, AveragesTheColoursOfEqualViewsWithoutStalling) {
  TsdfVolume volume = make_volume(fixed_band());
  see_wall(volume, 0.8, {200, 100, 255});
  for (int i = 0; i < 100; ++i) see_wall(volume, 0.8, {203, 97, 0});  // by less than the steps of eight bits
  const Rgb8 colour = wall_colour(volume);
  EXPECT_NEAR(colour.r, 203, 1);
  EXPECT_NEAR(colour.g, 97, 1);
  EXPECT_NEAR(colour.b, 0, 1);
}

TEST(Integrate, PrefersTheColourOfTheBetterView) {
  TsdfVolume near_first = make_volume(fixed_band());
  see_wall(near_first, 0.5, {200, 100, 0});
  for (int i = 0; i < 4; ++i) see_wall(near_first, 2.0, {0, 0, 255});
  TsdfVolume far_first = make_volume(fixed_band());
  for (int i = 0; i < 4; ++i) see_wall(far_first, 2.0, {0, 0, 255});
  see_wall(far_first, 0.5, {200, 100, 0});
  for (const TsdfVolume* volume : {&near_first, &far_first}) {
    EXPECT_NEAR(wall_colour(*volume).r, 200, 10);
    EXPECT_NEAR(wall_colour(*volume).b, 0, 12);
  }
}

TEST(Integrate, SaysWhereNoColourWasSeen) {
  TsdfVolume volume = make_volume(fixed_band());
  ASSERT_TRUE(integrate(plane_frame(small_camera(), {0, 0, -1}, -0.8), Pose::Identity(), volume));
  EXPECT_FALSE(volume.voxel({0, 0, 80}).colour);
}

TEST(Integrate, TellsWhichBlocksChanged) {
  TsdfVolume volume = make_volume(fixed_band());
  see_wall(volume, 0.8, {1, 2, 3});
  EXPECT_EQ(volume.take_changed_blocks().size(), volume.blocks());
  EXPECT_TRUE(volume.take_changed_blocks().empty());
  const Frame ball = sphere_frame(small_camera(), {0, 0, 0.7}, 0.05);
  ASSERT_TRUE(integrate(ball, Pose::Identity(), volume));
  const auto changed = volume.take_changed_blocks();
  EXPECT_FALSE(changed.empty());
  EXPECT_LT(changed.size(), volume.blocks());
}

TEST(Integrate, KeepsOneTopologyInTheThreeGrids) {
  TsdfVolume volume = make_volume(fixed_band());
  for (int i = 0; i < 4; ++i) {
    const Pose pose = looking_at_origin({0.8 * std::cos(i), 0.8 * std::sin(i), 0.3});
    ASSERT_TRUE(integrate(sphere_frame(small_camera(), pose.inverse() * Eigen::Vector3d::Zero(), 0.2), pose, volume));
  }
  EXPECT_TRUE(volume.tsdf().tree().hasSameTopology(volume.weight().tree()));
  EXPECT_TRUE(volume.tsdf().tree().hasSameTopology(volume.colour().tree()));
}

TEST(Integrate, RefusesAPoseThatIsNotFiniteAndLeavesTheVolumeUntouched) {
  TsdfVolume volume = make_volume(fixed_band());
  Pose pose = Pose::Identity();
  pose.translation().x() = std::numeric_limits<double>::quiet_NaN();
  const auto result = integrate(plane_frame(small_camera(), {0, 0, -1}, -0.8), pose, volume);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kInput);
  EXPECT_EQ(volume.blocks(), 0u);
}

TEST(Integrate, RefusesAPoseThatScales) {
  TsdfVolume volume = make_volume(fixed_band());
  Pose pose = Pose::Identity();
  pose.linear() *= 1.1;
  EXPECT_FALSE(integrate(plane_frame(small_camera(), {0, 0, -1}, -0.8), pose, volume));
  EXPECT_EQ(volume.blocks(), 0u);
}

TEST(Integrate, RefusesAPoseBeyondTheIndexRange) {
  TsdfVolume volume = make_volume(fixed_band());
  Pose pose = Pose::Identity();
  pose.translation().x() = 1e12;
  EXPECT_FALSE(integrate(plane_frame(small_camera(), {0, 0, -1}, -0.8), pose, volume));
  EXPECT_EQ(volume.blocks(), 0u);
}

TEST(Integrate, RefusesACameraThatLooksBeyondTheIndexRange) {
  TsdfVolume volume = make_volume(fixed_band());
  Frame frame = plane_frame(small_camera(), {0, 0, -1}, -0.8);
  frame.intrinsics.cx = 1e15;
  EXPECT_FALSE(integrate(frame, Pose::Identity(), volume));
  EXPECT_EQ(volume.blocks(), 0u);
}

TEST(Integrate, AcceptsAFrameWithoutAnyReturn) {
  Frame frame;
  frame.intrinsics = small_camera();
  frame.depth_m = DepthImage(160, 120);
  TsdfVolume volume = make_volume(fixed_band());
  EXPECT_TRUE(integrate(frame, Pose::Identity(), volume));
  EXPECT_EQ(volume.blocks(), 0u);
}

TEST(Integrate, StopsGrowingAtTheBudgetAndSaysSo) {
  FusionConfig config = fixed_band();
  config.voxel_size_m = 0.003;
  config.memory_budget_mib = 8;
  TsdfVolume volume = make_volume(config);
  const auto stats = integrate(plane_frame(small_camera(), {0, 0, -1}, -0.8), Pose::Identity(), volume);
  ASSERT_TRUE(stats);
  EXPECT_TRUE(stats->is_budget_reached);
  EXPECT_TRUE(volume.is_budget_reached);
  EXPECT_GT(volume.blocks(), 0u);
  EXPECT_LE(volume.memory_bytes(), config.memory_budget_mib << 20);
}

TEST(Integrate, GivesTheSameBitsForAnyNumberOfThreads) {
  const auto fuse = [](int threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    TsdfVolume volume = make_volume(fixed_band());
    for (int i = 0; i < 5; ++i) {
      const Pose pose = looking_at_origin({0.8 * std::cos(i), 0.8 * std::sin(i), 0.1 * i});
      Frame frame = sphere_frame(small_camera(), pose.inverse() * Eigen::Vector3d::Zero(), 0.2);
      frame.colour = ColourFrame{ColourImage(160, 120, Rgb8{10, 20, 30}), small_camera(), Pose::Identity()};
      EXPECT_TRUE(integrate(frame, pose, volume));
    }
    return volume;
  };
  const TsdfVolume one = fuse(1);
  EXPECT_TRUE(are_equal(one, fuse(2)));
  EXPECT_TRUE(are_equal(one, fuse(8)));
}

/// Every block some pixel's band reaches, by walking each pixel's band in small steps.
std::set<Coord> band_blocks_by_walking(const Frame& frame, const Pose& T_world_camera, const FusionConfig& config) {
  std::set<Coord> blocks;
  const double truncation_m = config.truncation_voxels * config.voxel_size_m;
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = 0; x < frame.depth_m.width(); ++x) {
      const double z = static_cast<double>(frame.depth_m.at(x, y));
      if (z <= 0) continue;
      for (double t = -truncation_m; t <= truncation_m; t += config.voxel_size_m / 8) {
        const Eigen::Vector3d index = T_world_camera * frame.intrinsics.unproject(x, y, z + t) / config.voxel_size_m;
        const Coord nearest(static_cast<int>(std::lround(index.x())), static_cast<int>(std::lround(index.y())),
                            static_cast<int>(std::lround(index.z())));
        // Only samples that the pixel's ray passes within a hair count as its own.
        if ((index - Eigen::Vector3d(nearest.x(), nearest.y(), nearest.z())).norm() > 0.05) continue;
        blocks.insert(nearest & ~7);
      }
    }
  }
  return blocks;
}

std::set<Coord> origins_of(const std::vector<BandBlock>& blocks) {
  std::set<Coord> origins;
  for (const BandBlock& block : blocks) origins.insert(block.origin);
  return origins;
}

TEST(BandBlocks, MissNoBlockThatARayPassesThroughInTheBand) {
  for (const double angle : {0.0, 0.7, 2.1, 4.0}) {
    const Pose pose = looking_at_origin({0.9 * std::cos(angle), 0.9 * std::sin(angle), 0.4});
    const Frame frame = sphere_frame(small_camera(), pose.inverse() * Eigen::Vector3d::Zero(), 0.25);
    const FusionConfig config = fixed_band();
    const Observation observation(frame, config);
    const auto found = find_band_blocks(observation, pose, config.voxel_size_m);
    const std::set<Coord> found_set = origins_of(found);
    EXPECT_EQ(found_set.size(), found.size()) << "a block twice";
    const auto walked = band_blocks_by_walking(frame, pose, config);
    ASSERT_GT(walked.size(), 40u);
    for (const Coord& block : walked) EXPECT_TRUE(found_set.count(block)) << block;
  }
}

std::vector<Coord> blocks_of_cube(int from, int to) {
  std::vector<Coord> blocks;
  for (int i = from; i < to; i += 8) {
    for (int j = from; j < to; j += 8) {
      for (int k = from; k < to; k += 8) blocks.emplace_back(i, j, k);
    }
  }
  return blocks;
}

/// Twelve views of a ball, fused in some order; with noise if there is one.
TsdfVolume fused_in_order(const std::vector<int>& steps, bool has_noise) {
  const FusionConfig config;
  TsdfVolume volume = make_volume(config);
  for (const int i : steps) {
    const Pose pose = looking_at_origin({0.8 * std::cos(0.3 * i), 0.8 * std::sin(0.3 * i), 0.3 + 0.02 * i});
    Frame frame = sphere_frame(small_camera(), pose.inverse() * Eigen::Vector3d::Zero(), 0.2);
    std::mt19937 random(static_cast<unsigned>(i));
    std::normal_distribution<double> gaussian;
    for (float& z : frame.depth_m.pixels()) {
      const double drawn = gaussian(random);
      if (has_noise && z > 0) z += static_cast<float>(drawn * config.noise.sigma_m(static_cast<double>(z)));
    }
    EXPECT_TRUE(integrate(frame, pose, volume));
  }
  return volume;
}

class OrderOfFrames : public ::testing::TestWithParam<bool> {};

TEST_P(OrderOfFrames, MattersLittle) {
  const TsdfVolume forwards = fused_in_order({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, GetParam());
  const TsdfVolume mixed = fused_in_order({7, 0, 11, 4, 2, 9, 5, 10, 1, 8, 3, 6}, GetParam());
  const double voxel_m = forwards.config().voxel_size_m;
  // The mean is the same but for rounding. Only what grazing views and free space say of a block depends on whether it
  // was there when they saw it: docs/fusion.md states these bounds.
  constexpr float kBarelySeen = 0.05f;  // a twentieth of one view at a right angle from near
  double voxels = 0, off_by_a_thousandth = 0, off_by_a_tenth = 0, most = 0;
  for (auto value = forwards.tsdf().cbeginValueOn(); value; ++value) {
    if (std::abs(static_cast<double>(*value)) > voxel_m) continue;
    const Voxel own = forwards.voxel(value.getCoord());
    const Voxel other = mixed.voxel(value.getCoord());
    const double off_m = std::abs(static_cast<double>(own.tsdf_m) - static_cast<double>(other.tsdf_m));
    const double off_voxels = other.weight > 0 ? off_m / voxel_m : 1;
    ++voxels;
    off_by_a_thousandth += off_voxels > 0.001 ? 1 : 0;
    off_by_a_tenth += off_voxels > 0.1 ? 1 : 0;
    if (std::min(own.weight, other.weight) >= kBarelySeen) most = std::max(most, off_voxels);
  }
  EXPECT_GT(voxels, 40'000);
  EXPECT_LT(off_by_a_thousandth, 0.004 * voxels);
  EXPECT_LT(off_by_a_tenth, 0.002 * voxels);
  EXPECT_LT(most, 0.02);
}

INSTANTIATE_TEST_SUITE_P(WithNoise, OrderOfFrames, ::testing::Bool());

/// The distances that a frame gives the voxels of an empty block; NaN where it says nothing.
std::array<float, kBlockVoxels> integrate_block(const FrameView& view, const Coord& block) {
  const BlockPlace place = view.place(Eigen::Vector3d(block.x(), block.y(), block.z()), 1e30f);
  std::array<float, kBlockVoxels> tsdf{};
  std::array<WeightCode, kBlockVoxels> weight{};
  std::array<ColourCode, kBlockVoxels> colour{};
  BlockChange change;
  update_block(view, place, {tsdf.data(), weight.data(), colour.data()}, change);
  for (std::size_t n = 0; n < kBlockVoxels; ++n) {
    if (((change.observed[n / 64] >> (n % 64)) & 1) == 0) tsdf[n] = std::numeric_limits<float>::quiet_NaN();
  }
  return tsdf;
}

TEST(BandBlocks, FindEveryBlockWithAVoxelInTheBand) {
  const Pose pose = looking_at_origin({0.6, -0.5, 0.4});
  const Frame frame = sphere_frame(small_camera(), pose.inverse() * Eigen::Vector3d::Zero(), 0.25);
  const FusionConfig config = fixed_band();
  const Observation observation(frame, config);
  const auto found = find_band_blocks(observation, pose, config.voxel_size_m);
  const std::set<Coord> found_set = origins_of(found);
  const Pose T_camera_world = pose.inverse();
  const FrameView view(observation.planes(), frame.intrinsics, T_camera_world, config);
  const float band_m = static_cast<float>(config.truncation_voxels * config.voxel_size_m);
  std::size_t exhaustive = 0;
  for (const Coord& block : blocks_of_cube(-48, 48)) {
    const auto changed = integrate_block(view, block);
    for (std::size_t n = 0; n < kBlockVoxels; ++n) {
      if (!(std::abs(changed[n]) < band_m)) continue;
      const auto x = static_cast<int>(n / 64), y = static_cast<int>(n / 8 % 8), z = static_cast<int>(n % 8);
      const Eigen::Vector3d p =
          T_camera_world * (Eigen::Vector3d(block.x() + x, block.y() + y, block.z() + z) * kVoxel);
      // Where the surface turns away the band is cut at a slope of 1/4: see Observation.
      const Eigen::Vector2d pixel = frame.intrinsics.project(p);
      const float depth_m =
          frame.depth_m.at(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
      if (depth_m == 0 || std::abs(static_cast<double>(depth_m) - p.z()) > static_cast<double>(band_m)) continue;
      ++exhaustive;
      EXPECT_TRUE(found_set.count(block)) << block;
    }
  }
  EXPECT_GT(exhaustive, 10000u);
}

TEST(BlockCounter, CountsWhatIntegrationAllocates) {
  const FusionConfig config = fixed_band();
  TsdfVolume volume = make_volume(config);
  BlockCounter counter(config, std::size_t{1} << 30);
  for (int i = 0; i < 4; ++i) {
    const Pose pose = looking_at_origin({0.8 * std::cos(i), 0.8 * std::sin(i), 0.3});
    const Frame frame = sphere_frame(small_camera(), pose.inverse() * Eigen::Vector3d::Zero(), 0.2);
    counter.add(frame, pose);
    ASSERT_TRUE(integrate(frame, pose, volume));
  }
  EXPECT_GE(counter.blocks(), volume.blocks());
  EXPECT_LE(counter.blocks(), volume.blocks() + volume.blocks() / 4);  // blocks that only touch the band are taken back
}

TEST(BlockCounter, StopsAtItsLimit) {
  const Frame wall = plane_frame(small_camera(), {0, 0, -1}, -0.8);
  BlockCounter all(fixed_band(), std::size_t{1} << 30);
  all.add(wall, Pose::Identity());
  EXPECT_FALSE(all.is_full());
  BlockCounter some(fixed_band(), std::size_t{4} << 20);
  some.add(wall, Pose::Identity());
  EXPECT_TRUE(some.is_full());
  EXPECT_LT(some.blocks(), all.blocks());
}

}  // namespace
}  // namespace scanknit
