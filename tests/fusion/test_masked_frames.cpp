// Masks in fusion: what counts less, and what is only known to be free.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "fusion/integrate/integrate.h"
#include "fusion/picture_part.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using test::bare_wall;
using test::look;
using test::World;

constexpr double kVoxel_m = 0.01;
constexpr double kWall_m = 1.0;
const Eigen::Vector3d kVisitor(0, 0, 0.6);
constexpr double kVisitorRadius = 0.1;

TsdfVolume make_volume(bool carves = true) {
  FusionConfig config;
  config.voxel_size_m = kVoxel_m;
  config.carve_free_space = carves;
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  return std::move(volume).value();
}

void fuse(const Frame& frame, TsdfVolume& volume, int times = 1) {
  for (int i = 0; i < times; ++i) ASSERT_TRUE(integrate(frame, Pose::Identity(), volume));
}

Frame look_at_wall() {
  return look(bare_wall(), Pose::Identity(), /*has_colour=*/false);
}

/// A mask took out all of it.
Frame outside(Frame frame) {
  const DepthImage nothing(frame.depth_m.width(), frame.depth_m.height());
  frame.outside_m = std::exchange(frame.depth_m, nothing);
  frame.normals = {};
  return frame;
}

/// Observed voxels behind a surface, in front of the wall's band.
std::size_t matter_before_wall(const TsdfVolume& volume) {
  std::size_t count = 0;
  for (auto value = volume.tsdf().cbeginValueOn(); value; ++value) {
    if (*value < 0 && value.getCoord().z() * kVoxel_m < kWall_m - 0.15) ++count;
  }
  return count;
}

TsdfVolume with_visitor(bool carves = true) {
  TsdfVolume volume = make_volume(carves);
  const World visited = bare_wall().add_ball(kVisitor, kVisitorRadius);
  fuse(look(visited, Pose::Identity(), /*has_colour=*/false), volume, 3);
  EXPECT_GT(matter_before_wall(volume), 100u);
  return volume;
}

TEST(MaskedFrames, APixelCountsAsItsWeightSays) {
  TsdfVolume whole = make_volume(), fifth = make_volume(), all = make_volume();
  Frame frame = look_at_wall();
  fuse(frame, whole);
  frame.weights = Image<std::uint8_t>(frame.depth_m.width(), frame.depth_m.height(), 51);
  fuse(frame, fifth);
  frame.weights = Image<std::uint8_t>(frame.depth_m.width(), frame.depth_m.height(), 255);
  fuse(frame, all);
  const Coord at(0, 0, 100);
  ASSERT_GT(whole.voxel(at).weight, 0);
  constexpr float kCode = 0.02f;  // weights are codes of some digits
  EXPECT_NEAR(fifth.voxel(at).weight / whole.voxel(at).weight, 0.2f, kCode);
  EXPECT_EQ(all.voxel(at).weight, whole.voxel(at).weight);
  EXPECT_EQ(all.tsdf().activeVoxelCount(), whole.tsdf().activeVoxelCount());
}

TEST(MaskedFrames, TheBetterPartOfAMaskOutvotesItsRim) {
  TsdfVolume volume = make_volume();
  Frame nearer = look(World().add_wall({0, 0, -1}, -(kWall_m - 0.02)), Pose::Identity(), /*has_colour=*/false);
  nearer.weights = Image<std::uint8_t>(nearer.depth_m.width(), nearer.depth_m.height(), 16);
  fuse(look_at_wall(), volume);
  fuse(nearer, volume);
  const auto tsdf_at = [&](int z) { return volume.voxel(Coord(0, 0, z)).tsdf_m; };
  EXPECT_GT(tsdf_at(99), 0);  // with equal weights the surface would be here
  EXPECT_LT(tsdf_at(101), 0);
}

TEST(MaskedFrames, WhatStoodInFrontOfTheOutsideIsCarved) {
  TsdfVolume volume = with_visitor();
  fuse(outside(look_at_wall()), volume, 60);
  EXPECT_EQ(matter_before_wall(volume), 0u);
}

TEST(MaskedFrames, TheOutsideBecomesNoSurface) {
  TsdfVolume volume = make_volume();
  fuse(outside(look_at_wall()), volume, 3);
  EXPECT_EQ(volume.blocks(), 0u);
  EXPECT_FALSE(volume.is_budget_reached);
}

TEST(MaskedFrames, TheOutsideMovesNoVoxelOfItsBand) {
  TsdfVolume volume = make_volume();
  fuse(look_at_wall(), volume);
  const Voxel before = volume.voxel(Coord(3, 4, 99)), at = volume.voxel(Coord(3, 4, 101));
  fuse(outside(look_at_wall()), volume, 20);
  EXPECT_EQ(volume.voxel(Coord(3, 4, 99)).weight, before.weight);
  EXPECT_EQ(volume.voxel(Coord(3, 4, 101)).tsdf_m, at.tsdf_m);
}

TEST(MaskedFrames, TheUnknownOutsideCarvesNothing) {
  TsdfVolume volume = with_visitor();
  const std::size_t matter = matter_before_wall(volume);
  Frame unknown = outside(look_at_wall());
  unknown.outside_m = {};
  fuse(unknown, volume, 60);
  EXPECT_EQ(matter_before_wall(volume), matter);
}

TEST(MaskedFrames, NothingIsOutsideWithoutCarving) {
  TsdfVolume volume = with_visitor(/*carves=*/false);
  const std::size_t matter = matter_before_wall(volume);
  fuse(outside(look_at_wall()), volume, 60);
  EXPECT_EQ(matter_before_wall(volume), matter);
}

TEST(MaskedFrames, GiveTheSameBitsOnAnyNumberOfThreads) {
  const auto fused = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    TsdfVolume volume = with_visitor();
    Frame frame = look_at_wall();
    frame.outside_m = frame.depth_m;
    frame.weights = Image<std::uint8_t>(frame.depth_m.width(), frame.depth_m.height(), 100);
    for (int y = 20; y < 90; ++y) std::fill(frame.depth_m.row(y).begin(), frame.depth_m.row(y).end(), 0.0f);
    fuse(frame, volume, 10);
    std::vector<std::pair<float, float>> values;
    for (auto value = volume.tsdf().cbeginValueOn(); value; ++value) {
      const Voxel voxel = volume.voxel(value.getCoord());
      values.emplace_back(voxel.tsdf_m, voxel.weight);
    }
    return values;
  };
  const auto one = fused(1);
  EXPECT_GT(one.size(), 10'000u);
  EXPECT_EQ(one, fused(2));
}

TEST(MaskedFrames, AreCroppedWithWhatTheirMasksSay) {
  Frame frame = look_at_wall();
  frame.weights = Image<std::uint8_t>(frame.depth_m.width(), frame.depth_m.height());
  frame.outside_m = DepthImage(frame.depth_m.width(), frame.depth_m.height());
  frame.labels = frame.weights;
  frame.weights.at(30, 20) = 77;
  frame.outside_m.at(31, 21) = 2.5f;
  frame.labels.at(32, 22) = 3;
  crop_frame(frame, {10, 15, 59, 54});
  for (const auto& [width, height] : {std::pair(frame.weights.width(), frame.weights.height()),
                                      std::pair(frame.outside_m.width(), frame.outside_m.height()),
                                      std::pair(frame.labels.width(), frame.labels.height())}) {
    EXPECT_EQ(width, 50);
    EXPECT_EQ(height, 40);
  }
  EXPECT_EQ(frame.weights.at(20, 5), 77);
  EXPECT_EQ(frame.outside_m.at(21, 6), 2.5f);
  EXPECT_EQ(frame.labels.at(22, 7), 3);
}

}  // namespace
}  // namespace scanknit
