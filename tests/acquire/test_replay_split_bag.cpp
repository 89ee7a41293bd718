// Bags of ROS 2 in several files.
#include <gtest/gtest.h>

#include "db3_bag.h"
#include "robot_frames.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

/// What stands still, then a frame a part.
std::vector<Ros2Bag> robot_parts() {
  const Robot robot;
  std::vector<Ros2Bag> parts(3);
  robot.add_still(parts[0]);
  robot.add_frame(parts[1], Robot::kSecond, 1);
  robot.add_frame(parts[2], Robot::kLater, 2);
  return parts;
}

std::string metadata_of(const std::vector<std::string>& names) {
  std::string yaml = "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n";
  for (const std::string& name : names) yaml += "    - " + name + "\n";
  return yaml + "  duration:\n    nanoseconds: 1\n";
}

class SplitBag : public ::testing::Test {
 protected:
  SplitBag() {
    const auto parts = robot_parts();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      write_bytes(folder_ / ("walk/walk_" + std::to_string(i) + ".mcap"), parts[i].file());
    }
  }
  void write_metadata(const std::vector<std::string>& names) const {
    write_text(folder_ / "walk/metadata.yaml", metadata_of(names));
  }
  [[nodiscard]] std::vector<std::string> warnings() const {
    const auto source = open_recording(folder_ / "walk", {});
    EXPECT_TRUE(source) << source.error().text();
    return source ? (*source)->info().warnings : std::vector<std::string>{};
  }

  TemporaryFolder folder_;
};

TEST_F(SplitBag, IsOneRecording) {
  write_metadata({"walk_0.mcap", "walk_1.mcap", "walk_2.mcap"});
  expect_robot(play(folder_ / "walk"));
  EXPECT_TRUE(warnings().empty());
}

TEST_F(SplitBag, OfAnEarlyRosbag2NamesItsFolderToo) {
  write_metadata({"walk/walk_0.mcap", "walk/walk_1.mcap", "walk/walk_2.mcap"});
  expect_robot(play(folder_ / "walk"));
}

TEST_F(SplitBag, WithoutMetadataIsJoinedByItsNumbers) {
  expect_robot(play(folder_ / "walk"));
  EXPECT_TRUE(warnings().empty());
}

TEST_F(SplitBag, MayHavePartsOfAllKinds) {
  const auto file = db3_file(robot_parts()[1].log());
  if (!file) GTEST_SKIP() << "SKIPPED: python3 with sqlite3 is not installed";
  write_bytes(folder_ / "walk/b.db3", *file);
  write_bytes(folder_ / "walk/c.mcap.zstd", zstd_pack(robot_parts()[2].file()));
  write_metadata({"walk_0.mcap", "b.db3", "c.mcap.zstd"});
  expect_robot(play(folder_ / "walk"));
}

TEST_F(SplitBag, TakesItsPartsInTheOrderOfTheMetadata) {
  write_metadata({"walk_0.mcap", "walk_2.mcap", "walk_1.mcap"});
  const Played p = play(folder_ / "walk");
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[0].timestamp_ns, Robot::kLater);
}

TEST_F(SplitBag, LosesWithAPartOnlyItsFrames) {
  write_metadata({"walk_0.mcap", "walk_1.mcap", "walk_2.mcap"});
  fs::remove(folder_ / "walk/walk_1.mcap");
  EXPECT_EQ(play(folder_ / "walk").frames.size(), 1u);
  ASSERT_EQ(warnings().size(), 1u);
  EXPECT_TRUE(contains(warnings()[0], "part 'walk_1.mcap' is left out, with its frames: it is not there"));
  fs::remove(folder_ / "walk/metadata.yaml");
  ASSERT_EQ(warnings().size(), 1u);
  EXPECT_TRUE(contains(warnings()[0], "walk_1.mcap")) << "the gap in the numbers";
}

TEST_F(SplitBag, LosesWithADamagedPartOnlyItsFrames) {
  write_metadata({"walk_0.mcap", "walk_1.mcap", "walk_2.mcap"});
  write_text(folder_ / "walk/walk_1.mcap", "no bag at all");
  EXPECT_EQ(play(folder_ / "walk").frames.size(), 1u);
  EXPECT_TRUE(contains(warnings().at(0), "walk_1.mcap"));
}

TEST_F(SplitBag, ReadsNothingOutsideItsFolder) {
  const fs::path outside = folder_ / "outside.mcap";
  fs::rename(folder_ / "walk/walk_1.mcap", outside);
  fs::create_symlink(outside, folder_ / "walk/link.mcap");
  for (const std::string& name : {outside.string(), std::string("../outside.mcap"), std::string("link.mcap")}) {
    write_metadata({"walk_0.mcap", name, "walk_2.mcap"});
    EXPECT_EQ(play(folder_ / "walk").frames.size(), 1u) << name;
    EXPECT_TRUE(contains(warnings().at(0), "is left out")) << name;
  }
}

TEST_F(SplitBag, WithoutAnyOfItsPartsNamesTheFirst) {
  write_metadata({"x_0.mcap", "x_1.mcap"});
  EXPECT_TRUE(contains(open_error(folder_ / "walk"), "x_0.mcap")) << open_error(folder_ / "walk");
}

TEST_F(SplitBag, BesideAnotherIsNotJoined) {
  write_bytes(folder_ / "walk/other_0.mcap", robot_bag().file());
  EXPECT_TRUE(contains(open_error(folder_ / "walk"), "holds 4 recordings; name one of them"));
}

}  // namespace
}  // namespace scanknit::test
