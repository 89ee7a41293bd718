#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>

#include "export/mesh/up_rotation.h"

namespace scanknit {
namespace {

constexpr std::array kAxes = {UpAxis::kX, UpAxis::kY, UpAxis::kZ, UpAxis::kMinusX, UpAxis::kMinusY, UpAxis::kMinusZ};

TEST(UpRotation, TakesOneUpToTheOther) {
  for (const UpAxis from : kAxes) {
    for (const UpAxis to : kAxes) EXPECT_EQ(up_rotation(from, to) * direction(from), direction(to));
  }
}

TEST(UpRotation, NeverMirrors) {
  for (const UpAxis from : kAxes) {
    for (const UpAxis to : kAxes) EXPECT_EQ(up_rotation(from, to).determinant(), 1.0f);
  }
}

TEST(UpRotation, IsOrthogonal) {
  for (const UpAxis from : kAxes) {
    for (const UpAxis to : kAxes) {
      const Eigen::Matrix3f r = up_rotation(from, to);
      EXPECT_EQ(r * r.transpose(), Eigen::Matrix3f::Identity());
    }
  }
}

TEST(UpRotation, ACamerasWorldTurnsAboutX) {
  const Eigen::Matrix3f expected = Eigen::Vector3f(1, -1, -1).asDiagonal();
  EXPECT_EQ(up_rotation(UpAxis::kMinusY, UpAxis::kY), expected);
}

TEST(UpRotation, BackIsTheInverse) {
  for (const UpAxis from : kAxes) {
    for (const UpAxis to : kAxes) {
      EXPECT_EQ(up_rotation(from, to) * up_rotation(to, from), Eigen::Matrix3f::Identity());
    }
  }
}

}  // namespace
}  // namespace scanknit
