#include "fusion/shutter/deskew.h"

#include <gtest/gtest.h>

#include "tests/fusion/small_world.h"
#include "tests/support/instruction_sets.h"

namespace scanknit {
namespace {

using test::look;
using test::on_circle;
using test::small_camera;
using test::small_room;

/// A quick turn: 3.4 degrees and 4 cm between the first row and the last.
SteadyMotion quick_rows() {
  return {{0.02, 0.055, 0.01}, {0.04, 0.01, 0.01}};
}

Frame skewed() {
  return look(small_room(), on_circle(0), true, small_camera(), quick_rows());
}

/// Of the pixels that both frames have, the share that differs in some way.
template <typename Differ>
double share_of(const Frame& a, const Frame& b, Differ differ) {
  double different = 0, all = 0;
  for (int y = 0; y < a.depth_m.height(); ++y) {
    for (int x = 0; x < a.depth_m.width(); ++x) {
      if (!(a.depth_m.at(x, y) > 0 && b.depth_m.at(x, y) > 0)) continue;
      ++all;
      different += differ(x, y) ? 1 : 0;
    }
  }
  EXPECT_GT(all, 0.8 * a.depth_m.width() * a.depth_m.height());
  return different / all;
}

double share_of_wrong_depths(const Frame& a, const Frame& b) {
  return share_of(a, b, [&](int x, int y) { return std::abs(a.depth_m.at(x, y) - b.depth_m.at(x, y)) > 0.002f; });
}

double share_of_wrong_normals(const Frame& a, const Frame& b) {
  return share_of(a, b, [&](int x, int y) { return a.normals.at(x, y).dot(b.normals.at(x, y)) < 0.9998f; });
}

/// Wrong by more than the nearest pixel is where the pattern is steepest.
double share_of_wrong_colours(const Frame& a, const Frame& b) {
  constexpr int kHalfAPixel = 15;
  return share_of(a, b, [&](int x, int y) {
    return std::abs(int{a.colour->image.at(x, y).r} - int{b.colour->image.at(x, y).r}) > kHalfAPixel;
  });
}

TEST(Deskew, MakesTheFrameThatTheMiddleRowsPoseSees) {
  const Frame truth = look(small_room(), on_circle(0));
  Frame frame = skewed();
  ASSERT_GT(share_of_wrong_depths(frame, truth), 0.6);
  ASSERT_GT(share_of_wrong_normals(frame, truth), 0.4);
  deskew({quick_rows(), {}}, frame);
  // What is left lies beside the edges of the balls.
  EXPECT_LT(share_of_wrong_depths(frame, truth), 0.06);
  EXPECT_LT(share_of_wrong_normals(frame, truth), 0.12);
}

TEST(Deskew, ReadsColoursWhereTheyWereSeen) {
  const SteadyMotion turn{quick_rows().turn_rad, Eigen::Vector3d::Zero()};  // a shift depends on each pixel's depth
  const Frame truth = look(small_room(), on_circle(0));
  Frame frame = look(small_room(), on_circle(0), true, small_camera(), turn);
  ASSERT_GT(share_of_wrong_colours(frame, truth), 0.4);
  deskew({turn, {}}, frame);
  EXPECT_LT(share_of_wrong_colours(frame, truth), 0.1);
}

TEST(Deskew, MovesDepthWithoutNormalsToo) {
  const Frame truth = look(small_room(), on_circle(0));
  Frame frame = skewed();
  frame.normals = {};
  const double before = share_of_wrong_depths(frame, truth);
  deskew({quick_rows(), {}}, frame);
  EXPECT_TRUE(frame.normals.empty());
  EXPECT_LT(share_of_wrong_depths(frame, truth), before);
}

TEST(Deskew, LeavesAFrameAloneThatMovesByLessThanHalfAPixel) {
  const Frame frame = skewed();
  for (const double share : {0.0, 0.001}) {
    Frame same = frame;
    deskew({quick_rows() * share, quick_rows() * share}, same);
    EXPECT_EQ(share_of(frame, same, [&](int x, int y) { return frame.depth_m.at(x, y) != same.depth_m.at(x, y); }), 0);
    EXPECT_EQ(share_of_wrong_colours(frame, same), 0);
    EXPECT_TRUE(same.colour->T_colour_depth.isApprox(frame.colour->T_colour_depth));
  }
}

TEST(Deskew, PlacesTheColourCameraWhereItWasWhenItTookThePicture) {
  Frame frame = skewed();
  const Pose T_now_later = test::motion({0, 0.02, 0}, {0.01, 0, 0.005});
  deskew({{}, SteadyMotion::from(T_now_later)}, frame);
  EXPECT_TRUE(frame.colour->T_colour_depth.isApprox(T_now_later.inverse()));
}

Frame deskewed(Frame frame) {
  deskew({quick_rows(), {}}, frame);
  return frame;
}

TEST(Deskew, GivesTheSameWithEveryInstructionSet) {
  const Frame first = deskewed(skewed());
  test::for_each_instruction_set([&] {
    const Frame frame = deskewed(skewed());
    EXPECT_EQ(frame.depth_m, first.depth_m);
    EXPECT_EQ(frame.normals, first.normals);
    EXPECT_EQ(frame.colour->image, first.colour->image);
  });
}

// Pixels are straightened sixteen at a time.
TEST(Deskew, TakesPicturesOfAnyWidth) {
  const Frame whole = deskewed(skewed());
  for (const int width : {5, 37, 64}) {
    CameraIntrinsics camera = small_camera();
    camera.width = width;
    const Frame part = deskewed(look(small_room(), on_circle(0), true, camera, quick_rows()));
    ASSERT_EQ(part.depth_m.width(), width);
    int seen = 0;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!(part.depth_m.at(x, y) > 0)) continue;  // what the rows saw beyond the right edge
        ++seen;
        EXPECT_EQ(part.depth_m.at(x, y), whole.depth_m.at(x, y)) << x << ", " << y;
        EXPECT_EQ(part.normals.at(x, y), whole.normals.at(x, y)) << x << ", " << y;
      }
    }
    EXPECT_GT(seen, 0.3 * width * camera.height);
  }
}

TEST(Deskew, KeepsAFrameWithoutDepth) {
  Frame frame = skewed();
  frame.depth_m = DepthImage(frame.depth_m.width(), frame.depth_m.height());
  deskew({quick_rows(), {}}, frame);
  EXPECT_EQ(frame.depth_m.width(), small_camera().width);
  EXPECT_EQ(frame.depth_m.at(5, 5), 0);
}

}  // namespace
}  // namespace scanknit
