// What every bag of Robot (ros2_bag.h) gives, in whatever container it is.
#pragma once

#include <gtest/gtest.h>

#include "test_replay_support.h"

namespace scanknit::test {

inline void expect_robot(const Played& p) {
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 2u);
  const Frame& frame = p.frames[1];
  EXPECT_EQ(frame.timestamp_ns, 1'050'000'000) << "of the header, not of the recorder";
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{4, 2, 4, 4.5, 1.5, 0.5}));
  EXPECT_EQ(frame.depth_m.at(0, 0), 1.0F);
  EXPECT_EQ(frame.depth_m.at(3, 1), 1.007F);
  ASSERT_TRUE(frame.colour);
  EXPECT_EQ(frame.colour->image.at(3, 1), (Rgb8{77, 77, 77}));
  EXPECT_EQ(frame.colour->intrinsics, (CameraIntrinsics{4, 2, 5, 5, 1.5, 0.5}));
  EXPECT_TRUE(frame.colour->T_colour_depth.isApprox(Pose(Eigen::Translation3d(-0.015, 0, 0))));
  ASSERT_TRUE(frame.T_world_camera);
  EXPECT_TRUE((*frame.T_world_camera * Eigen::Vector3d(0, 0, 3)).isApprox(Eigen::Vector3d(5, 0, 0)))
      << "forward is the robot's x";
  EXPECT_TRUE((frame.T_world_camera->linear() * Eigen::Vector3d::UnitY()).isApprox(-Eigen::Vector3d::UnitZ()));
}

}  // namespace scanknit::test
