// The frames that `convert --frames` chooses.
#include <gtest/gtest.h>

#include <sstream>

#include "acquire/convert/sharpest_frames.h"
#include "core/picture/png_codec.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

/// Stripes; the greater the contrast, the sharper.
ColourImage stripes(std::uint8_t contrast) {
  ColourImage picture(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (x % 2 == 0) picture.at(x, y) = {contrast, contrast, contrast};
    }
  }
  return picture;
}

TEST(Sharpness, IsTheVarianceOfTheLaplacian) {
  EXPECT_EQ(sharpness(ColourImage(9, 9)), 0);
  EXPECT_EQ(sharpness(ColourImage(2, 9)), 0);
  ColourImage dot(5, 5);
  dot.at(2, 2) = {30, 30, 30};
  // -4 x 30 at the dot, 30 at four of its neighbours, 0 at the others: the mean is 0.
  EXPECT_DOUBLE_EQ(sharpness(dot), 20.0 * 30 * 30 / 9);
  EXPECT_GT(sharpness(stripes(200)), sharpness(stripes(100)));
}

/// Frames at places along x, each with stripes of a contrast; 0: without colour.
class SharpestFrames : public ::testing::Test {
 protected:
  void write(const std::vector<double>& places, const std::vector<std::uint8_t>& contrasts) const {
    write_text(folder_ / "camera_intrinsic.json",
               R"({"width": 8, "height": 6, "intrinsic_matrix": [100, 0, 0, 0, 110, 0, 3.5, 2.5, 1]})");
    std::ostringstream log;
    for (std::size_t i = 0; i < contrasts.size(); ++i) {
      const std::string name = std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png";
      write_depth(folder_ / ("depth/" + name), 1000);
      const auto png = encode_png(stripes(contrasts[i]), PngEffort::kMedium).value();
      const auto bytes = std::as_bytes(std::span(png));
      write_bytes(folder_ / ("color/" + name), {bytes.begin(), bytes.end()});
      if (!places.empty()) log << "0 0 0\n1 0 0 " << places[i] << "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    }
    if (!places.empty()) write_text(folder_ / "trajectory.log", log.str());
  }
  [[nodiscard]] std::unique_ptr<FrameSource> open() const {
    AcquireConfig config;
    config.poses = PoseMode::kTrack;
    return *open_recording(folder_.path(), config);
  }
  [[nodiscard]] std::vector<std::size_t> chosen(std::size_t count) const {
    const auto source = open();
    const auto found = find_sharpest_frames(*source, count, {}, {});
    EXPECT_TRUE(found) << found.error().text();
    return found ? *found : std::vector<std::size_t>{};
  }

  TemporaryFolder folder_;
};

using Positions = std::vector<std::size_t>;

TEST_F(SharpestFrames, AreOneOfEachPartOfTheWay) {
  // The first half of the way has two frames, the second has four.
  write({0, 4, 10, 11, 12, 20}, {90, 100, 10, 80, 70, 60});
  EXPECT_EQ(chosen(2), (Positions{1, 3}));
  EXPECT_EQ(chosen(1), Positions{1});
  EXPECT_EQ(chosen(4), (Positions{1, 3, 5})) << "no frame is in the second quarter";
}

TEST_F(SharpestFrames, OfACameraThatStandsStillAreOneOfEachPartOfItsFrames) {
  write({0, 0, 0, 0}, {10, 20, 40, 30});
  EXPECT_EQ(chosen(2), (Positions{1, 2}));
}

TEST_F(SharpestFrames, AreAllWhereThereAreNoMore) {
  write({0, 1, 2}, {10, 10, 10});
  EXPECT_EQ(chosen(300), (Positions{0, 1, 2}));
}

TEST_F(SharpestFrames, NeedPoses) {
  write({}, {10, 20});
  const auto source = open();
  const auto found = find_sharpest_frames(*source, 2, {}, {});
  ASSERT_FALSE(found);
  EXPECT_TRUE(contains(found.error().message, "no frame has a pose"));
}

TEST_F(SharpestFrames, AreTheOnlyOnesThatAreGiven) {
  write({0, 1, 2, 3}, {10, 20, 30, 40});
  const auto source = only_frames(open(), {1, 3});
  const Played p = play(*source);
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[0].T_world_camera->translation().x(), 1);
  EXPECT_EQ(p.frames[1].T_world_camera->translation().x(), 3);
}

}  // namespace
}  // namespace scanknit::test
