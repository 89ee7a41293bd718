#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "fusion/silhouette/hull_cubes.h"
#include "fusion/silhouette/silhouette.h"
#include "fusion/silhouette/visual_hull.h"
#include "fusion/volume/block_index.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr CameraIntrinsics kHullCamera{640, 480, 700, 700, 319.5, 239.5};
constexpr double kFromAxis_m = 0.6;
constexpr double kFootprint_m = kFromAxis_m / 700;  // of a pixel on the thing

/// A camera at `from` that looks at the world's origin; y is down.
Pose looking_at_origin(const Vector3d& from) {
  const Vector3d forward = -from.normalized();
  const Vector3d right = Vector3d::UnitY().cross(forward).normalized();
  Pose pose = Pose::Identity();
  pose.linear().col(0) = right;
  pose.linear().col(1) = forward.cross(right);
  pose.linear().col(2) = forward;
  pose.translation() = from;
  return pose;
}

/// Round the y axis, in turn from a little above and from below.
std::vector<Pose> circle(int count) {
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    const double up = i % 2 == 0 ? -0.35 : 0.15;
    const Vector3d from(std::sin(angle) * std::cos(up), std::sin(up), std::cos(angle) * std::cos(up));
    poses.push_back(looking_at_origin(kFromAxis_m * from));
  }
  return poses;
}

/// A convex thing whose cone from any eye is known exactly.
class ConvexThing {
 public:
  virtual ~ConvexThing() = default;
  /// Signed distance of a point to the cone from the eye round the thing, positive outside of it; exact near the cone.
  [[nodiscard]] virtual double to_cone(const Vector3d& eye, const Vector3d& p) const = 0;
};

class Ball final : public ConvexThing {
 public:
  explicit Ball(double radius_m) : radius_m_(radius_m) {}
  double to_cone(const Vector3d& eye, const Vector3d& p) const override {
    const Vector3d axis = -eye.normalized();
    const double half_angle = std::asin(radius_m_ / eye.norm());
    const double angle = std::acos(std::clamp((p - eye).normalized().dot(axis), -1.0, 1.0));
    return (p - eye).norm() * std::sin(angle - half_angle);
  }

 private:
  double radius_m_;
};

/// The convex hull of some points. The cone is bounded by planes through the eye and two of the points.
class Polytope final : public ConvexThing {
 public:
  explicit Polytope(std::vector<Vector3d> corners) : corners_(std::move(corners)) {}
  double to_cone(const Vector3d& eye, const Vector3d& p) const override {
    if (eye != eye_) find_planes(eye);
    double most = -1e9;
    for (const Vector3d& normal : planes_) most = std::max(most, normal.dot(p - eye));
    return most;
  }

 private:
  void find_planes(const Vector3d& eye) const {
    eye_ = eye;
    planes_.clear();
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      for (std::size_t j = i + 1; j < corners_.size(); ++j) {
        Vector3d normal = (corners_[i] - eye).cross(corners_[j] - eye);
        if (normal.norm() < 1e-12) continue;
        normal.normalize();
        double low = 0, high = 0;
        for (const Vector3d& corner : corners_) {
          low = std::min(low, normal.dot(corner - eye));
          high = std::max(high, normal.dot(corner - eye));
        }
        if (high < 1e-9) planes_.push_back(normal);
        if (low > -1e-9) planes_.emplace_back(-normal);
      }
    }
  }
  std::vector<Vector3d> corners_;
  mutable Vector3d eye_ = Vector3d::Zero();
  mutable std::vector<Vector3d> planes_;
};

Polytope box_thing() {
  std::vector<Vector3d> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back((k & 1) != 0 ? 0.1 : -0.1, (k & 2) != 0 ? 0.06 : -0.06, (k & 4) != 0 ? 0.08 : -0.08);
  }
  return Polytope(std::move(corners));
}

Polytope cylinder_thing() {
  std::vector<Vector3d> corners;
  constexpr int kSides = 48;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    for (const double y : {-0.09, 0.09}) corners.emplace_back(0.07 * std::sin(angle), y, 0.07 * std::cos(angle));
  }
  return Polytope(std::move(corners));
}

/// White where the pixel's centre sees the thing.
Image<std::uint8_t> mask_of(const ConvexThing& thing, const CameraIntrinsics& camera, const Pose& T_world_camera) {
  Image<std::uint8_t> mask(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d p = T_world_camera * camera.unproject(x, y, kFromAxis_m);
      mask.at(x, y) = thing.to_cone(T_world_camera.translation(), p) <= 0 ? 255 : 0;
    }
  }
  return mask;
}

std::vector<SilhouetteView> views_of(const ConvexThing& thing, const std::vector<Pose>& poses) {
  std::vector<SilhouetteView> views;
  for (const Pose& pose : poses) {
    views.push_back({kHullCamera, pose, Silhouette(mask_of(thing, kHullCamera, pose), 16)});
  }
  return views;
}

TsdfVolume hull_volume(double voxel_size_m) {
  FusionConfig config;
  config.voxel_size_m = voxel_size_m;
  return *TsdfVolume::create(config);
}

struct HullErrors {
  double mean_m = 0, worst_m = 0;
  std::size_t voxels = 0;
};

/// Of the voxels within a voxel of the exact hull of these views.
HullErrors errors_of(const TsdfVolume& volume, const ConvexThing& thing, const std::vector<Pose>& poses) {
  std::vector<Vector3d> near;
  const double size = volume.config().voxel_size_m;
  std::vector<double> found;
  for (const VolumeBlock& block : volume.index().blocks()) {
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      if (!block.tsdf->isValueOn(n)) continue;
      const float distance = block.tsdf->buffer().data()[n];
      if (std::abs(distance) > 2 * size) continue;
      near.emplace_back((block.origin.x() + static_cast<int>(n >> 6)) * size,
                        (block.origin.y() + static_cast<int>(n >> 3 & 7)) * size,
                        (block.origin.z() + static_cast<int>(n & 7)) * size);
      found.push_back(distance);
    }
  }
  std::vector<double> exact(near.size(), -1e9);
  for (const Pose& pose : poses) {  // view by view: a polytope keeps the planes of one eye
    for (std::size_t i = 0; i < near.size(); ++i) {
      exact[i] = std::max(exact[i], thing.to_cone(pose.translation(), near[i]));
    }
  }
  HullErrors errors;
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (std::abs(exact[i]) > size) continue;
    const double error = std::abs(found[i] - exact[i]);
    errors.mean_m += error;
    errors.worst_m = std::max(errors.worst_m, error);
    ++errors.voxels;
  }
  errors.mean_m /= static_cast<double>(std::max<std::size_t>(1, errors.voxels));
  return errors;
}

void expect_hull_within_half_a_pixel(const ConvexThing& thing) {
  const std::vector<Pose> poses = circle(36);
  const std::vector<SilhouetteView> views = views_of(thing, poses);
  const auto box = hull_box(views);
  ASSERT_TRUE(box) << box.error().text();
  TsdfVolume volume = hull_volume(kFootprint_m);
  const auto carved = carve_hull(views, *box, volume);
  ASSERT_TRUE(carved) << carved.error().text();
  const HullErrors errors = errors_of(volume, thing, poses);
  EXPECT_GT(errors.voxels, 50'000u);
  EXPECT_LT(errors.mean_m, 0.5 * kFootprint_m);
  EXPECT_LT(errors.worst_m, 2 * kFootprint_m);
  for (const SilhouetteView& view : views) EXPECT_GT(compare_silhouette(view, volume).agreement, 0.995);
}

TEST(VisualHull, OfABallIsWithinHalfAPixel) {
  expect_hull_within_half_a_pixel(Ball(0.1));
}

TEST(VisualHull, OfABoxIsWithinHalfAPixel) {
  expect_hull_within_half_a_pixel(box_thing());
}

TEST(VisualHull, OfACylinderIsWithinHalfAPixel) {
  expect_hull_within_half_a_pixel(cylinder_thing());
}

/// What HullBlocks leaves out, because views that see a place say no more, changes nothing.
TEST(VisualHull, EveryVoxelHasTheGreatestOfAllViews) {
  const Polytope thing = box_thing();
  CameraIntrinsics cut = kHullCamera;  // the thing reaches beyond the picture's border
  cut.cx = 40;
  std::vector<SilhouetteView> views = views_of(thing, circle(12));
  for (const Pose& pose : circle(5)) views.push_back({cut, pose, Silhouette(mask_of(thing, cut, pose), 16)});
  TsdfVolume volume = hull_volume(3 * kFootprint_m);
  ASSERT_TRUE(carve_hull(views, *hull_box(views), volume));
  const double size = volume.config().voxel_size_m;
  const float band_m = volume.tsdf().background();
  std::size_t voxels = 0;
  for (const VolumeBlock& block : volume.index().blocks()) {
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      const openvdb::Coord at = block.tsdf->offsetToGlobalCoord(n);
      float greatest_m = -band_m;
      int seen_by = 0;
      for (const SilhouetteView& view : views) {
        const Vector3d p = view.T_world_camera.inverse() * (Vector3d(at.x(), at.y(), at.z()) * size);
        const Eigen::Vector2d pixel = view.camera.project(p);
        if (!view.silhouette.sees(pixel.x(), pixel.y())) continue;
        ++seen_by;
        const double distance_m =
            static_cast<double>(view.silhouette.distance_px(pixel.x(), pixel.y())) * p.z() / focal_length(view.camera);
        greatest_m = std::max(greatest_m, std::min(static_cast<float>(distance_m), band_m));
      }
      ASSERT_EQ(block.tsdf->isValueOn(n), seen_by >= kFewestSilhouettes);
      if (!block.tsdf->isValueOn(n)) continue;
      ASSERT_EQ(block.weight->getValue(n), encode_weight(static_cast<float>(seen_by)));
      ASSERT_NEAR(block.tsdf->buffer().data()[n], greatest_m, 2e-5f * band_m);
      ++voxels;
    }
  }
  EXPECT_GT(voxels, 10'000u);
}

TEST(VisualHull, HoldsTheWholeThing) {
  const Ball ball(0.1);
  const std::vector<SilhouetteView> views = views_of(ball, circle(6));
  const auto box = hull_box(views);
  ASSERT_TRUE(box) << box.error().text();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(box->min()[axis], -0.1);
    EXPECT_GE(box->max()[axis], 0.1);
  }
  TsdfVolume volume = hull_volume(0.002);
  ASSERT_TRUE(carve_hull(views, *box, volume));
  std::size_t carved_away = 0, inside = 0;
  for (const VolumeBlock& block : volume.index().blocks()) {
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      if (!block.tsdf->isValueOn(n)) continue;
      const Vector3d p(block.origin.x() + static_cast<int>(n >> 6), block.origin.y() + static_cast<int>(n >> 3 & 7),
                       block.origin.z() + static_cast<int>(n & 7));
      if ((p * 0.002).norm() >= 0.1 - 0.001) continue;
      ++inside;
      if (block.tsdf->buffer().data()[n] >= 0) ++carved_away;
    }
  }
  EXPECT_GT(inside, 10'000u);
  EXPECT_EQ(carved_away, 0u);
}

TEST(VisualHull, IsTheSameForEveryOrderOfViews) {
  std::vector<SilhouetteView> views = views_of(box_thing(), circle(8));
  const auto box = hull_box(views);
  ASSERT_TRUE(box);
  TsdfVolume first = hull_volume(0.004);
  ASSERT_TRUE(carve_hull(views, *box, first));
  std::reverse(views.begin(), views.end());
  TsdfVolume second = hull_volume(0.004);
  ASSERT_TRUE(carve_hull(views, *box, second));
  ASSERT_EQ(first.blocks(), second.blocks());
  for (std::size_t i = 0; i < first.blocks(); ++i) {
    const VolumeBlock &a = first.index().blocks()[i], &b = second.index().blocks()[i];
    ASSERT_EQ(a.origin, b.origin);
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      ASSERT_EQ(a.tsdf->buffer().data()[n], b.tsdf->buffer().data()[n]);
      ASSERT_EQ(a.weight->buffer().data()[n], b.weight->buffer().data()[n]);
    }
  }
}

TEST(VisualHull, IsTheSameForAnyNumberOfThreads) {
  const std::vector<SilhouetteView> views = views_of(box_thing(), circle(6));
  const auto box = hull_box(views);
  ASSERT_TRUE(box) << box.error().text();
  const ColourImage picture(kHullCamera.width, kHullCamera.height, Rgb8{90, 120, 30});
  const auto carved_by = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    TsdfVolume volume = hull_volume(0.004);
    EXPECT_TRUE(carve_hull(views, *box, volume));
    std::vector<ColourOfView> colours;
    for (const SilhouetteView& view : views) colours.push_back({&picture, view.camera, view.T_world_camera});
    paint_hull(colours, volume);
    return volume;
  };
  const TsdfVolume one = carved_by(1), four = carved_by(4);
  ASSERT_EQ(one.blocks(), four.blocks());
  for (std::size_t i = 0; i < one.blocks(); ++i) {
    const VolumeBlock &a = one.index().blocks()[i], &b = four.index().blocks()[i];
    ASSERT_EQ(a.origin, b.origin);
    for (unsigned n = 0; n < kBlockVoxels; ++n) {
      ASSERT_EQ(a.tsdf->buffer().data()[n], b.tsdf->buffer().data()[n]);
      ASSERT_EQ(colours_of(*a.colour)[n].bits, colours_of(*b.colour)[n].bits);
    }
  }
}

TEST(VisualHull, RefusesMoreThanTheMemoryHolds) {
  const std::vector<SilhouetteView> views = views_of(Ball(0.1), circle(4));
  const auto box = hull_box(views);
  ASSERT_TRUE(box) << box.error().text();
  FusionConfig config;
  config.voxel_size_m = 0.0001;  // some million blocks
  config.memory_budget_mib = 64;
  auto volume = TsdfVolume::create(config);
  ASSERT_TRUE(volume);
  const auto carved = carve_hull(views, *box, *volume);
  ASSERT_FALSE(carved);
  EXPECT_EQ(carved.error().code, ErrorCode::kBudget);
}

TEST(VisualHull, RefusesViewsThatBoundNothing) {
  const Ball ball(0.1);
  const auto refused = [](const std::vector<SilhouetteView>& views) {
    const auto box = hull_box(views);
    return box ? std::string() : box.error().message;
  };
  const std::vector<SilhouetteView> views = views_of(ball, circle(4));
  EXPECT_NE(refused({views[0]}).find("at least two"), std::string::npos);
  EXPECT_NE(refused({views[0], views[0]}).find("same direction"), std::string::npos);
  std::vector<SilhouetteView> away = views;
  for (SilhouetteView& view : away) view.T_world_camera.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitY()));
  EXPECT_NE(refused(away).find("look away"), std::string::npos);
}

TEST(VisualHull, TakesTheColoursOfTheViewsThatSeeTheSurface) {
  const Ball ball(0.1);
  const std::vector<SilhouetteView> views = views_of(ball, circle(8));
  const auto box = hull_box(views);
  ASSERT_TRUE(box);
  TsdfVolume volume = hull_volume(0.004);
  ASSERT_TRUE(carve_hull(views, *box, volume));
  // Each picture has the colour of its side: red towards +z, blue towards -z.
  std::vector<ColourImage> pictures;
  for (const SilhouetteView& view : views) {
    const bool is_red = view.T_world_camera.translation().z() > 0;
    pictures.emplace_back(kHullCamera.width, kHullCamera.height, is_red ? Rgb8{250, 0, 0} : Rgb8{0, 0, 250});
  }
  std::vector<ColourOfView> colours;
  for (std::size_t i = 0; i < views.size(); ++i) {
    colours.push_back({&pictures[i], views[i].camera, views[i].T_world_camera});
  }
  paint_hull(colours, volume);
  const Voxel front = volume.voxel(openvdb::Coord(0, 0, 25)), back = volume.voxel(openvdb::Coord(0, 0, -25));
  ASSERT_TRUE(front.colour && back.colour);
  EXPECT_GT(front.colour->r, 240);
  EXPECT_LT(front.colour->b, 10);
  EXPECT_GT(back.colour->b, 240);
  EXPECT_LT(back.colour->r, 10);
}

TEST(SilhouetteTest, MeasuresDistancesToItsOutline) {
  Image<std::uint8_t> mask(80, 60);
  for (int y = 20; y < 40; ++y) {
    for (int x = 30; x < 50; ++x) mask.at(x, y) = 255;
  }
  const Silhouette square(mask, 12);
  EXPECT_NEAR(square.distance_px(24.5, 30), 5, 0.02);  // the outline is between the pixels 29 and 30
  EXPECT_NEAR(square.distance_px(34.5, 30), -5, 0.02);
  EXPECT_NEAR(square.distance_px(29.5, 30), 0, 0.02);
  EXPECT_NEAR(square.distance_px(5, 30), 12, 0.01) << "not measured beyond the reach";
  const auto outside = square.range_px({2, 2, 8, 8});
  ASSERT_TRUE(outside);
  EXPECT_NEAR(outside->least_px, 12, 0.01);
  const auto across = square.range_px({20, 25, 40, 35});
  ASSERT_TRUE(across);
  EXPECT_LT(across->least_px, -9);
  EXPECT_GT(across->greatest_px, 9);
  EXPECT_FALSE(square.range_px({-1, 2, 8, 8}));
  ASSERT_TRUE(square.bounds());
  EXPECT_EQ(square.bounds()->left, 30);
  EXPECT_EQ(square.bounds()->bottom, 39);
}

TEST(SilhouetteTest, TakesSharesOfPixelsAsTheyAre) {
  Image<std::uint8_t> mask(40, 40);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double share = std::clamp(20.25 + 0.5 - x, 0.0, 1.0);  // the thing ends at 20.25
      mask.at(x, y) = static_cast<std::uint8_t>(std::lround(255 * share));
    }
  }
  const Silhouette half(mask, 8);
  constexpr double kLinear_px = 0.09;  // shares are taken as heights of a straight line between the centres
  EXPECT_NEAR(half.distance_px(20.25, 20), 0, kLinear_px);
  EXPECT_NEAR(half.distance_px(23.25, 20), 3, kLinear_px);
}

TEST(SilhouetteTest, KeepsALineOfOnePixel) {
  Image<std::uint8_t> mask(40, 40);
  for (int y = 5; y < 35; ++y) mask.at(20, y) = 255;
  const Silhouette line(mask, 8);
  EXPECT_LT(line.distance_px(20, 20), 0);
}

}  // namespace
}  // namespace scanknit
