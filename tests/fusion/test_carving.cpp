// What moves away leaves nothing behind, and what stays is not eaten away.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <optional>
#include <random>
#include <vector>

#include "fusion/integrate/integrate.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using test::look;
using test::on_circle;
using test::small_room;
using test::World;

constexpr double kVoxel = 0.01;

FusionConfig room_config(bool carves = true) {
  FusionConfig config;
  config.voxel_size_m = kVoxel;
  config.carve_free_space = carves;
  return config;
}

TsdfVolume make_volume(const FusionConfig& config) {
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  return std::move(volume).value();
}

/// Is there another depth beside this pixel, farther than any slope here makes it?
std::optional<float> depth_across_step(const DepthImage& depth_m, int x, int y) {
  constexpr float kStep_m = 0.1f;
  for (const auto& [dx, dy] : {std::array{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    if (!depth_m.contains(x + dx, y + dy)) continue;
    const float other = depth_m.at(x + dx, y + dy);
    if (std::abs(other - depth_m.at(x, y)) > kStep_m) return other;
  }
  return std::nullopt;
}

/// Noise as `noise` says, and pixels beside a step smeared: half of them lie anywhere between the two surfaces.
void add_noise(Frame& frame, const NoiseModel& noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> gaussian;
  std::uniform_real_distribution<float> uniform;
  const DepthImage exact = frame.depth_m;
  for (int y = 0; y < exact.height(); ++y) {
    for (int x = 0; x < exact.width(); ++x) {
      float& z = frame.depth_m.at(x, y);
      const float drawn = gaussian(random), smears = uniform(random), flight = uniform(random);
      const auto across = depth_across_step(exact, x, y);
      if (across && smears < 0.5f) z += flight * (*across - z);
      z += drawn * static_cast<float>(noise.sigma_m(static_cast<double>(z)));
    }
  }
}

/// Fuses one frame for each of `worlds`: the camera sways as one in a hand does.
TsdfVolume fuse_from_the_hand(const std::vector<World>& worlds) {
  const FusionConfig config = room_config();
  TsdfVolume volume = make_volume(config);
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const double t = static_cast<double>(i);
    const Pose pose = on_circle(0) *
                      test::motion({0.02 * std::sin(t / 3), 0.05 * std::sin(t / 5), 0}, {0.05 * std::sin(t / 4), 0, 0});
    Frame frame = look(worlds[i], pose, /*has_colour=*/false);
    add_noise(frame, config.noise, static_cast<unsigned>(i));
    EXPECT_TRUE(integrate(frame, pose, volume));
  }
  return volume;
}

/// Observed voxels behind a surface within a ball: where there is one, the mesh has a piece there.
std::size_t voxels_of_matter(const TsdfVolume& volume, const Eigen::Vector3d& centre, double radius_m) {
  std::size_t count = 0;
  for (auto value = volume.tsdf().cbeginValueOn(); value; ++value) {
    const Coord& c = value.getCoord();
    const Eigen::Vector3d p = kVoxel * Eigen::Vector3d(c.x(), c.y(), c.z());
    if (*value < 0 && (p - centre).norm() <= radius_m) ++count;
  }
  return count;
}

const Eigen::Vector3d kVisitor(-0.1, -0.4,
                               -0.4);  // 0.6 m from the camera, before walls 2.5 m away and the rim of a ball
constexpr double kVisitorRadius = 0.12;
constexpr double kReach = kVisitorRadius + 5 * kVoxel;  // and the band round it
constexpr std::size_t kViewsAfter = 60;

std::vector<World> visited_for(std::size_t frames) {
  std::vector<World> worlds(frames, small_room().add_ball(kVisitor, kVisitorRadius));
  worlds.resize(frames + kViewsAfter, small_room());
  return worlds;
}

class VisitorThatStood : public ::testing::TestWithParam<std::size_t> {};

TEST_P(VisitorThatStood, IsGoneAfterSixtyViewsOfWhatWasBehind) {
  const std::vector<World> worlds = visited_for(GetParam());
  ASSERT_GT(voxels_of_matter(fuse_from_the_hand({worlds.begin(), worlds.end() - kViewsAfter}), kVisitor, kReach), 500u);
  EXPECT_EQ(voxels_of_matter(fuse_from_the_hand(worlds), kVisitor, kReach), 0u);
}

TEST_P(VisitorThatStood, LeavesTheRestAsItIs) {
  const std::vector<World> visited = visited_for(GetParam());
  const TsdfVolume with = fuse_from_the_hand(visited);
  const TsdfVolume without = fuse_from_the_hand(std::vector<World>(visited.size(), small_room()));
  double squares = 0, count = 0;
  for (auto value = without.tsdf().cbeginValueOn(); value; ++value) {
    if (std::abs(*value) > kVoxel) continue;
    const Voxel other = with.voxel(value.getCoord());
    if (other.weight == 0) continue;  // the visitor hid it
    const double off_m = static_cast<double>(other.tsdf_m) - static_cast<double>(*value);
    squares += off_m * off_m;
    ++count;
  }
  ASSERT_GT(count, 20'000);
  EXPECT_LT(std::sqrt(squares / count), room_config().noise.sigma_m(2.0) / 3);  // of one reading, averaged over 3 x 3
}

INSTANTIATE_TEST_SUITE_P(Frames, VisitorThatStood, ::testing::Values(std::size_t{5}, std::size_t{20}),
                         ::testing::PrintToStringParamName());

TEST(Carving, SomebodyWhoWalksThroughThePictureLeavesNothing) {
  std::vector<World> worlds;
  std::vector<Eigen::Vector3d> places;
  for (int step = 0; step < 40; ++step) {
    World world = small_room();
    for (int ball = 0; ball < 4; ++ball) {
      places.emplace_back(-1.2 + 0.06 * step, -0.6 + 0.15 * ball, -0.45);
      world.add_ball(places.back(), 0.1);
    }
    worlds.push_back(world);
  }
  worlds.resize(worlds.size() + 10, small_room());
  const TsdfVolume volume = fuse_from_the_hand(worlds);
  std::size_t left = 0;
  for (const Eigen::Vector3d& place : places) left += voxels_of_matter(volume, place, 0.14);
  EXPECT_EQ(left, 0u);
}

/// Is there a surface within a voxel's diagonal of p?
bool has_surface(const TsdfVolume& volume, const Eigen::Vector3d& p) {
  const auto nearest = [&](int axis) { return static_cast<int>(std::lround(p[axis] / kVoxel)); };
  const Coord centre(nearest(0), nearest(1), nearest(2));
  bool is_before = false, is_behind = false;
  for (int n = 0; n < 27; ++n) {
    const Voxel voxel = volume.voxel(centre + Coord(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
    if (voxel.weight == 0) continue;
    is_before = is_before || voxel.tsdf_m >= 0;
    is_behind = is_behind || voxel.tsdf_m < 0;
  }
  return is_before && is_behind;
}

/// A pole of 3 cm and a plate of 2.4 cm, both made of balls, with the room behind them.
class ThinThings {
 public:
  ThinThings() {
    for (int i = 0; i < 60; ++i) balls_.push_back({{0.45, -0.45 + 0.01 * i, -0.2}, 0.015});
    for (int i = 0; i < 20; ++i) {
      for (int j = 0; j < 20; ++j) balls_.push_back({{-0.3 + 0.01 * i, -0.35 + 0.01 * j, -0.35}, 0.012});
    }
  }

  [[nodiscard]] World world() const {
    World world = small_room();
    for (const auto& [centre, radius_m] : balls_) world.add_ball(centre, radius_m);
    return world;
  }

  /// Points of their surface.
  [[nodiscard]] std::vector<Eigen::Vector3d> surface() const {
    std::vector<Eigen::Vector3d> points;
    for (const auto& [centre, radius_m] : balls_) {
      for (int n = 0; n < 8; ++n) {
        const double angle = n * test::kPi / 4;
        const Eigen::Vector3d p = centre + radius_m * Eigen::Vector3d(std::sin(angle), 0, std::cos(angle));
        if (!is_inside(p)) points.push_back(p);
      }
    }
    return points;
  }

 private:
  struct Ball {
    Eigen::Vector3d centre;
    double radius_m;
  };
  [[nodiscard]] bool is_inside(const Eigen::Vector3d& p) const {
    constexpr double kRounding = 1e-9;
    return std::any_of(balls_.begin(), balls_.end(),
                       [&](const Ball& ball) { return (p - ball.centre).norm() < ball.radius_m - kRounding; });
  }
  std::vector<Ball> balls_;
};

TEST(Carving, ThinThingsSeenFromAllRoundStayAsCompleteAsWithoutIt) {
  const World world = ThinThings().world();
  const std::vector<Eigen::Vector3d> surface = ThinThings().surface();
  const auto complete = [&](bool carves) {
    const FusionConfig config = room_config(carves);
    TsdfVolume volume = make_volume(config);
    for (int step = 0; step < 120; step += 2) {
      Frame frame = look(world, on_circle(step), /*has_colour=*/false);
      add_noise(frame, config.noise, static_cast<unsigned>(step));
      EXPECT_TRUE(integrate(frame, on_circle(step), volume));
    }
    double found = 0;
    for (const Eigen::Vector3d& p : surface) found += has_surface(volume, p) ? 1 : 0;
    return found / static_cast<double>(surface.size());
  };
  const double without = complete(false);
  const double with = complete(true);
  std::cout << "complete: " << without << " without carving, " << with << " with it\n";
  EXPECT_GE(with, without - 0.002);
}

}  // namespace
}  // namespace scanknit
