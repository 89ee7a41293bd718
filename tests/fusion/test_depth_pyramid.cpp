#include <gtest/gtest.h>

#include <random>

#include "fusion/integrate/depth_pyramid.h"

namespace scanknit {
namespace {

DepthRanges random_ranges(int width, int height, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> depth_m(0.5f, 4.0f);
  DepthRanges ranges(width, height);
  for (int i = 0; i < width * height; ++i) {
    if (random() % 3 == 0) continue;  // no return
    const float centre_m = depth_m(random);
    ranges.near_m(i / width)[i % width] = centre_m - 0.02f;
    ranges.far_m(i / width)[i % width] = centre_m + 0.02f;
  }
  return ranges;
}

bool contains(const DepthRanges& ranges, int x, int y) {
  return x >= 0 && y >= 0 && x < ranges.width() && y < ranges.height();
}

bool meets_by_looking_at_every_pixel(const DepthRanges& ranges, const PixelRect& rect, const DepthRange& range) {
  for (int y = rect.y0; y <= rect.y1; ++y) {
    for (int x = rect.x0; x <= rect.x1; ++x) {
      if (contains(ranges, x, y) && ranges.at(x, y).meets(range)) return true;
    }
  }
  return false;
}

float farthest_of_every_pixel(const DepthRanges& ranges, const PixelRect& rect) {
  float far_m = DepthRange{}.far_m;
  for (int y = rect.y0; y <= rect.y1; ++y) {
    for (int x = rect.x0; x <= rect.x1; ++x) {
      if (contains(ranges, x, y)) far_m = std::max(far_m, ranges.at(x, y).far_m);
    }
  }
  return far_m;
}

TEST(DepthPyramid, MissesNothingThatAPixelShows) {
  const DepthRanges ranges = random_ranges(37, 23, 1);
  const DepthPyramid pyramid{DepthRanges(ranges)};
  std::mt19937 random(2);
  std::uniform_int_distribution<int> x(-5, 41);
  std::uniform_int_distribution<int> y(-5, 27);
  std::uniform_real_distribution<float> z(0.3f, 4.2f);
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const int x0 = x(random);
    const int y0 = y(random);
    const PixelRect rect{x0, y0, x0 + static_cast<int>(random() % 30), y0 + static_cast<int>(random() % 20)};
    const float near_m = z(random);
    const DepthRange range{near_m, near_m + 0.05f};
    const DepthRanges::Sight sight = pyramid.look(rect, range);
    EXPECT_GE(sight.far_m, farthest_of_every_pixel(ranges, rect));
    if (!meets_by_looking_at_every_pixel(ranges, rect, range)) continue;
    ++hits;
    ASSERT_TRUE(sight.meets);
    ASSERT_TRUE(pyramid.may_meet(rect, range));
  }
  EXPECT_GT(hits, 1000);
}

TEST(DepthPyramid, LooksAtEveryPixelOfASmallRectangle) {
  const DepthRanges ranges = random_ranges(37, 23, 1);
  const DepthPyramid pyramid{DepthRanges(ranges)};
  for (int y = 0; y + 5 < 23; ++y) {
    for (int x = 0; x + 5 < 37; ++x) {
      const PixelRect rect{x, y, x + 5, y + 5};
      const DepthRange range{1, 1.1f};
      EXPECT_EQ(pyramid.look(rect, range).meets, meets_by_looking_at_every_pixel(ranges, rect, range));
    }
  }
}

TEST(DepthPyramid, MeetsNothingWithoutReturns) {
  const DepthPyramid pyramid{DepthRanges(16, 9)};
  EXPECT_FALSE(pyramid.may_meet({0, 0, 15, 8}, {0.0f, 100.0f}));
  EXPECT_FALSE(DepthPyramid{}.may_meet({0, 0, 15, 8}, {0.0f, 100.0f}));
}

}  // namespace
}  // namespace scanknit
