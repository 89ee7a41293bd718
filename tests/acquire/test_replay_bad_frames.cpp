// Bad frames: each is dropped with its reason and its file, and the recording goes on.
#include <gtest/gtest.h>

#include "acquire/replay/skipping_source.h"
#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

// Three frames, of which the middle one is then spoilt.
class BadFrame : public ::testing::Test {
 protected:
  void SetUp() override { write_seven_scenes(folder_.path(), 3); }
  [[nodiscard]] fs::path middle(std::string_view what) const { return folder_ / seven_scenes_name(1, what); }

  void expect_dropped(const char* reason, const std::string& file) const {
    const Played played = play(folder_.path());
    EXPECT_EQ(played.frames.size(), 2u);
    ASSERT_EQ(played.reasons(), Reasons{reason});
    EXPECT_EQ(played.dropped[0].sequence, 1u);
    EXPECT_NE(played.dropped[0].error.text().find(file), std::string::npos) << played.dropped[0].error.text();
  }

  TemporaryFolder folder_;
};

TEST_F(BadFrame, WithoutItsDepthFileIsMissing) {
  fs::remove(middle("depth.png"));
  expect_dropped("missing_file", "frame-000001.depth.png");
}

TEST_F(BadFrame, WithADanglingLinkIsMissing) {
  fs::remove(middle("depth.png"));
  fs::create_symlink("nowhere.png", middle("depth.png"));
  expect_dropped("missing_file", "frame-000001.depth.png");
}

TEST_F(BadFrame, ThatIsEmptyIsUnreadable) {
  write_text(middle("depth.png"), "");
  expect_dropped("unreadable", "frame-000001.depth.png: the file is empty");
}

TEST_F(BadFrame, ThatIsTruncatedIsUnreadable) {
  auto bytes = bytes_of(middle("depth.png"));
  bytes.resize(bytes.size() / 2);
  write_bytes(middle("depth.png"), bytes);
  expect_dropped("unreadable", "truncated PNG");
}

TEST_F(BadFrame, ThatIsNoPngIsUnreadable) {
  write_text(middle("depth.png"), "GIF89a and so on, long enough to hold a header of some kind");
  expect_dropped("unreadable", "not a PNG file");
}

TEST_F(BadFrame, OfEightBitsIsUnreadable) {
  write_grey8(middle("depth.png"), 50);
  expect_dropped("unreadable", "expected depth as a 16-bit grey PNG");
}

TEST_F(BadFrame, OfAnotherSizeMismatches) {
  write_depth(middle("depth.png"), 1000, kWidth + 1, kHeight);
  expect_dropped("size_mismatch", "9 x 6, the first frame's 8 x 6");
}

TEST_F(BadFrame, WithoutOneDepthPixelHasNoDepth) {
  write_depth(middle("depth.png"), 65535);
  expect_dropped("no_depth", "frame-000001.depth.png");
}

TEST_F(BadFrame, WithoutItsPoseHasNoPose) {
  fs::remove(middle("pose.txt"));
  expect_dropped("no_pose", "frame-000001");
}

TEST_F(BadFrame, WithNanInItsPoseHasABadPose) {
  write_text(middle("pose.txt"), "nan 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  expect_dropped("bad_pose", "frame-000001.pose.txt: the pose holds a value that is not finite");
}

TEST_F(BadFrame, WithAStretchingPoseHasABadPose) {
  write_text(middle("pose.txt"), "2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n");
  expect_dropped("bad_pose", "not rigid");
}

TEST_F(BadFrame, WithAMirroringPoseHasABadPose) {
  write_text(middle("pose.txt"), "-1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  expect_dropped("bad_pose", "mirrors");
}

TEST_F(BadFrame, WithAnEmptyPoseHasABadPose) {
  write_text(middle("pose.txt"), "");
  expect_dropped("bad_pose", "0 numbers, expected a 4x4 matrix");
}

TEST_F(BadFrame, WithWordsForAPoseHasABadPose) {
  write_text(middle("pose.txt"), "lost\n");
  expect_dropped("bad_pose", "not a number");
}

TEST_F(BadFrame, WithTruncatedColourIsUnreadable) {
  for (int i = 0; i < 3; ++i) write_colour(folder_ / seven_scenes_name(i, "color.jpg"), {9, 9, 9});
  auto bytes = bytes_of(middle("color.jpg"));
  bytes.resize(bytes.size() - 1);
  write_bytes(middle("color.jpg"), bytes);
  expect_dropped("unreadable", "frame-000001.color.jpg: truncated JPEG");
}

TEST_F(BadFrame, WithoutAColourFileKeepsItsDepth) {
  write_colour(folder_ / seven_scenes_name(0, "color.png"), {9, 9, 9});
  const Played played = play(folder_.path());
  ASSERT_EQ(played.frames.size(), 3u);
  EXPECT_TRUE(played.frames[0].colour.has_value());
  EXPECT_FALSE(played.frames[1].colour.has_value());
}

TEST_F(BadFrame, AtTheFrontDoesNotSetTheSize) {
  write_text(folder_ / seven_scenes_name(0, "depth.png"), "no picture");
  const Played played = play(folder_.path());
  EXPECT_EQ(played.reasons(), Reasons{"unreadable"});
  EXPECT_EQ(played.frames.size(), 2u);
}

TEST_F(BadFrame, IsNoneWhenTheScannerStoodStill) {
  write_text(middle("pose.txt"), "lost\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  const Played played = play(folder_.path(), config);
  ASSERT_EQ(played.frames.size(), 3u);
  EXPECT_TRUE(played.frames[1].T_world_camera->isApprox(Pose::Identity()));
}

TEST_F(BadFrame, MayHaveNoPoseOrABadOneWhereItIsTracked) {
  fs::remove(middle("pose.txt"));
  write_text(folder_ / seven_scenes_name(2, "pose.txt"), "lost\n");
  for (const PoseMode poses : {PoseMode::kTrack, PoseMode::kRefine}) {
    AcquireConfig config;
    config.poses = poses;
    const Played played = play(folder_.path(), config);
    ASSERT_EQ(played.frames.size(), 3u);
    EXPECT_TRUE(played.frames[0].T_world_camera.has_value());
    EXPECT_FALSE(played.frames[1].T_world_camera.has_value());
    EXPECT_FALSE(played.frames[2].T_world_camera.has_value());
  }
}

TEST_F(BadFrame, WithoutDepthTellsATrackerThatTheLensIsCovered) {
  write_depth(middle("depth.png"), 0);
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"no_depth"});
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  EXPECT_EQ(play(folder_.path(), config).frames.size(), 3u);
}

TEST_F(BadFrame, OfAnotherSizeThanItsCameraMismatches) {
  AcquireConfig config;
  config.intrinsics = CameraModel{{kWidth, kHeight + 1, 100, 100, 3, 2}, {}};
  EXPECT_EQ(play(folder_.path(), config).reasons(), (Reasons{"size_mismatch", "size_mismatch", "size_mismatch"}));
}

TEST_F(BadFrame, BeyondTheByteLimitIsUnreadable) {
  AcquireConfig config;
  config.limits.max_image_bytes = 8;
  EXPECT_EQ(play(folder_.path(), config).reasons(), (Reasons{"unreadable", "unreadable", "unreadable"}));
}

TEST_F(BadFrame, BeyondThePixelLimitIsUnreadable) {
  AcquireConfig config;
  config.limits.max_image_pixels = kWidth * kHeight - 1;
  EXPECT_EQ(play(folder_.path(), config).reasons(), (Reasons{"unreadable", "unreadable", "unreadable"}));
}

TEST_F(BadFrame, IsNotLookedAtWhereItIsPassedOver) {
  write_text(middle("depth.png"), "");
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  auto* skipping = dynamic_cast<SkippingSource*>(source->get());
  ASSERT_NE(skipping, nullptr);
  const FrameEvent first = (*source)->next({});
  EXPECT_EQ(std::get<Frame>(first).sequence, 0u);
  skipping->skip_until([](std::uint64_t sequence) { return sequence == 2; });
  const FrameEvent last = (*source)->next({});
  ASSERT_TRUE(std::holds_alternative<Frame>(last));
  EXPECT_EQ(std::get<Frame>(last).sequence, 2u);
  skipping->skip_until([](std::uint64_t) { return false; });
  EXPECT_TRUE(std::holds_alternative<EndOfStream>((*source)->next({})));
}

}  // namespace
}  // namespace scanknit::test
