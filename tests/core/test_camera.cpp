#include <gtest/gtest.h>

#include <limits>

#include "core/camera.h"

namespace scanknit {
namespace {

constexpr double kExact = 1e-12;  // a few roundings of double
constexpr CameraIntrinsics kCamera{640, 480, 525, 520, 319.5, 239.5};

TEST(CameraIntrinsics, ProjectsTheOpticalAxisToThePrincipalPoint) {
  EXPECT_TRUE(kCamera.project({0, 0, 2}).isApprox(Eigen::Vector2d(319.5, 239.5), kExact));
}

TEST(CameraIntrinsics, XIsRightAndYIsDown) {
  const Eigen::Vector2d pixel = kCamera.project({0.1, 0.2, 1});
  EXPECT_NEAR(pixel.x(), 319.5 + 52.5, kExact * 1000);
  EXPECT_NEAR(pixel.y(), 239.5 + 104.0, kExact * 1000);
}

TEST(CameraIntrinsics, UnprojectUndoesProject) {
  const Eigen::Vector3d p(0.3, -0.2, 1.7);
  const Eigen::Vector2d pixel = kCamera.project(p);
  EXPECT_TRUE(kCamera.unproject(pixel.x(), pixel.y(), p.z()).isApprox(p, kExact));
}

TEST(CameraIntrinsics, NegativeFocalLengthIsValidAndFlipsY) {
  CameraIntrinsics flipped = kCamera;
  flipped.fy = -480;
  EXPECT_TRUE(flipped.is_valid());
  EXPECT_LT(flipped.project({0, 0.1, 1}).y(), flipped.cy);
}

TEST(CameraIntrinsics, ResizedSeesTheSameRays) {
  const CameraIntrinsics half = kCamera.resized(320, 240);
  // The corner between the four central pixels is the same ray in both pictures: centres are integers.
  const Eigen::Vector3d ray = kCamera.unproject(319.5, 239.5, 1);
  EXPECT_TRUE(half.unproject(159.5, 119.5, 1).isApprox(ray, kExact));
  EXPECT_NEAR(half.unproject(-0.5, -0.5, 1).x(), kCamera.unproject(-0.5, -0.5, 1).x(), kExact);
  EXPECT_EQ(half.width, 320);
}

TEST(CameraIntrinsics, RefusesNoPixelsAndNoFocalLength) {
  CameraIntrinsics camera = kCamera;
  camera.width = 0;
  EXPECT_FALSE(camera.is_valid());
  camera = kCamera;
  camera.fx = 0;
  EXPECT_FALSE(camera.is_valid());
  camera = kCamera;
  camera.cx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.is_valid());
  EXPECT_FALSE(CameraIntrinsics{}.is_valid());
}

}  // namespace
}  // namespace scanknit
