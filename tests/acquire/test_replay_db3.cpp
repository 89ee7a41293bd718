// Bags of ROS 2 in SQLite: what SQLite wrote, what damage and malice do, and what zstd packed.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/bag_metadata.h"
#include "acquire/bag/sqlite_file.h"
#include "acquire/raw/raw_recording.h"
#include "db3_bag.h"
#include "robot_frames.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

#define SKIP_WITHOUT_SQLITE(file) \
  if (!(file)) GTEST_SKIP() << "SKIPPED: python3 with sqlite3 is not installed"

/// How many frames of a file in memory can be decoded; `warning`: the recording's first, where it can be opened.
std::size_t frames_in_db3(const Bytes& file, std::string* warning = nullptr) {
  const auto recording = index_ros2(std::make_unique<MemoryAccess>(file), "bag.db3", {});
  if (!recording) return 0;
  if (warning != nullptr) *warning = recording->warnings.empty() ? "none" : recording->warnings.front();
  const auto& entries = recording->entries;
  return static_cast<std::size_t>(std::count_if(entries.begin(), entries.end(), [&](const FrameEntry& entry) {
    return std::holds_alternative<DecodedFrame>(recording->decode(entry, {}));
  }));
}

class Db3File : public ::testing::TestWithParam<int> {};

TEST_P(Db3File, GivesFramesWithCamerasAndPoses) {
  const TemporaryFolder folder;
  const auto file = db3_file(robot_bag().log(), GetParam());
  SKIP_WITHOUT_SQLITE(file);
  write_bytes(folder / "bag/bag_0.db3", *file);
  write_text(folder / "bag/metadata.yaml", "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3\n");
  expect_robot(play(folder / "bag"));
  expect_robot(play(folder / "bag/bag_0.db3"));
}

INSTANTIATE_TEST_SUITE_P(PageSizes, Db3File, ::testing::Values(512, 1024, 4096, 65536));

TEST(Db3, GivesTheSameRowsAsSqlite) {
  std::mt19937 random(1);
  std::vector<Ros2Bag::Logged> log;
  for (int i = 0; i < 3000; ++i) {
    const std::size_t size = i % 50 == 0 ? random() % 20000 : random() % 300;
    Bytes data(size);
    for (std::byte& b : data) b = static_cast<std::byte>(random());
    log.push_back({"/t" + std::to_string(i % 7), "a/msg/B", static_cast<std::int64_t>(random()) * 1'000'003 - 5, data});
  }
  const auto file = db3_file(log, 512);
  SKIP_WITHOUT_SQLITE(file);
  const auto bag = open_db3_messages(std::make_unique<MemoryAccess>(*file), {});
  ASSERT_TRUE(bag) << bag.error().text();
  EXPECT_TRUE((*bag)->faults().empty());
  ASSERT_EQ((*bag)->size(), log.size());
  for (std::size_t i = 0; i < log.size(); ++i) {
    const BagEntry entry = (*bag)->entry(i);
    EXPECT_EQ((*bag)->topics()[entry.topic].name, log[i].topic);
    EXPECT_EQ((*bag)->topics()[entry.topic].type, "a/B");
    EXPECT_EQ(entry.log_ns, log[i].log_ns);
    const auto data = (*bag)->read(i);
    ASSERT_TRUE(data);
    EXPECT_TRUE(std::equal(data->begin(), data->end(), log[i].data.begin(), log[i].data.end())) << i;
  }
}

// SQLite itself gives nothing of a file that is cut.
TEST(Db3, CutAnywhereGivesWhatIsWhole) {
  constexpr std::size_t kFrames = 20;
  const Robot robot;
  Ros2Bag bag;
  robot.add_still(bag);
  for (std::size_t i = 0; i < kFrames; ++i) robot.add_frame(bag, Robot::kSecond + static_cast<std::int64_t>(i), 1);
  const auto file = db3_file(bag.log(), 512);
  SKIP_WITHOUT_SQLITE(file);
  std::size_t most = 0;
  for (std::size_t size = 0; size < file->size(); size += 7) {
    std::string warning = "the bag is torn";
    const Bytes cut(file->begin(), file->begin() + static_cast<std::ptrdiff_t>(size));
    most = std::max(most, frames_in_db3(cut, &warning));
    EXPECT_TRUE(contains(warning, "the bag is torn")) << size;
  }
  EXPECT_GT(most, kFrames / 2);
  EXPECT_LT(most, kFrames);
  EXPECT_EQ(frames_in_db3(*file), kFrames);
}

TEST(Db3, SurvivesAnyWrongByte) {
  const auto file = db3_file(robot_bag().log(), 512);
  SKIP_WITHOUT_SQLITE(file);
  for (std::size_t i = 0; i < file->size(); ++i) {
    for (const int change : {0x01, 0xFF}) {
      Bytes damaged = *file;
      damaged[i] ^= static_cast<std::byte>(change);
      EXPECT_LE(frames_in_db3(damaged), 2u);
    }
  }
}

TEST(Db3, WhosePagesLeadInCirclesEnds) {
  std::vector<Ros2Bag::Logged> log;
  for (int i = 0; i < 500; ++i) log.push_back({"/t", "a/msg/B", i, Bytes(100)});
  auto file = db3_file(log, 512);
  SKIP_WITHOUT_SQLITE(file);
  // Every child of an inner page becomes the page itself.
  for (std::size_t page = 0; page < file->size() / 512; ++page) {
    const std::size_t begin = page * 512;
    if ((*file)[begin] != std::byte{5}) continue;
    const auto number = static_cast<std::uint16_t>(page + 1);
    const auto set = [&](std::size_t at) {
      (*file)[at] = (*file)[at + 1] = {};
      (*file)[at + 2] = static_cast<std::byte>(number >> 8);
      (*file)[at + 3] = static_cast<std::byte>(number);
    };
    set(begin + 8);
    for (std::size_t cell = 0; cell < 20; ++cell) {
      const auto at = std::to_integer<std::size_t>((*file)[begin + 12 + 2 * cell]) * 256 +
                      std::to_integer<std::size_t>((*file)[begin + 13 + 2 * cell]);
      if (at > 0 && at < 508) set(begin + at);
    }
  }
  const auto bag = open_db3_messages(std::make_unique<MemoryAccess>(*file), {});
  EXPECT_TRUE(!bag || !(*bag)->faults().empty());
}

TEST(Db3, OfAnotherProgramIsRefusedWithWords) {
  const TemporaryFolder folder;
  const std::string path = (folder / "other.db3").string();
  const std::string command = "/usr/bin/python3 -c \"import sqlite3; d=sqlite3.connect('" + path +
                              "'); d.execute('CREATE TABLE topics(id INTEGER, name TEXT)'); d.commit()\"";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "SKIPPED: python3 with sqlite3 is not installed";
  EXPECT_TRUE(contains(open_error(path), "no bag of ROS 2: expected a table 'topics'")) << open_error(path);
}

TEST(Db3, HasLimits) {
  const auto file = db3_file(robot_bag().log());
  SKIP_WITHOUT_SQLITE(file);
  Limits limits;
  limits.max_frames = 5;
  EXPECT_FALSE(open_db3_messages(std::make_unique<MemoryAccess>(*file), limits));
  limits = {};
  limits.max_image_bytes = 60;
  const auto bag = open_db3_messages(std::make_unique<MemoryAccess>(*file), limits);
  ASSERT_TRUE(bag);
  EXPECT_FALSE((*bag)->read((*bag)->size() - 1));
}

TEST(Db3, SaysWhatTheRecorderLeftBesideIt) {
  const TemporaryFolder folder;
  const auto file = db3_file(robot_bag().log());
  SKIP_WITHOUT_SQLITE(file);
  write_bytes(folder / "bag.db3", *file);
  write_text(folder / "bag.db3-wal", "frames");
  const auto source = open_recording(folder / "bag.db3", {});
  ASSERT_TRUE(source);
  ASSERT_EQ((*source)->info().warnings.size(), 1u);
  EXPECT_TRUE(contains((*source)->info().warnings[0], "bag.db3-wal are not read"));
}

// rosbag2's "compression_mode: MESSAGE".
TEST(BagOfZstd, UnpacksMessages) {
  const TemporaryFolder folder;
  Ros2Bag packed;
  const Ros2Bag plain = robot_bag();
  for (const Ros2Bag::Logged& m : plain.log()) packed.add(m.topic, m.type, m.log_ns, zstd_pack(m.data));
  write_bytes(folder / "bag.mcap", packed.file());
  expect_robot(play(folder / "bag.mcap"));
  const auto file = db3_file(packed.log());
  SKIP_WITHOUT_SQLITE(file);
  write_bytes(folder / "bag.db3", *file);
  expect_robot(play(folder / "bag.db3"));
}

// "compression_mode: FILE".
TEST(BagOfZstd, UnpacksFiles) {
  const TemporaryFolder folder;
  write_bytes(folder / "a/bag_0.mcap.zstd", zstd_pack(robot_bag().file()));
  expect_robot(play(folder / "a"));
  const auto file = db3_file(robot_bag().log());
  SKIP_WITHOUT_SQLITE(file);
  write_bytes(folder / "b/bag_0.db3.zstd", zstd_pack(*file));
  expect_robot(play(folder / "b"));
}

TEST(BagOfZstd, CutAnywhereGivesWhatIsWhole) {
  const Bytes packed = zstd_pack(robot_bag().file());
  for (std::size_t size = 0; size < packed.size(); size += 7) {
    std::string warning = "the bag is torn";
    (void)frames_in_db3(Bytes(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size)), &warning);
    EXPECT_TRUE(contains(warning, "the bag is torn")) << size;
  }
  EXPECT_EQ(frames_in_db3(packed), 2u);
}

TEST(BagOfZstd, ThatWouldFillTheDiskIsRefused) {
  const Bytes bomb = zstd_pack([] {
    Bytes bytes = robot_bag().file();
    bytes.resize(64u << 20);
    return bytes;
  }());
  const auto recording = index_ros2(std::make_unique<MemoryAccess>(bomb), "bag.mcap.zstd", {});
  ASSERT_FALSE(recording);
  EXPECT_TRUE(contains(recording.error().message, "unpack it with 'zstd -d'"));
}

TEST(BagMetadata, ListsFilesInTheirOrder) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(files_of_bag("a:\n  relative_file_paths:\n    - b_1.mcap\n    - \"b 0.mcap\"\n    - 'c'\n  next: 1\n"),
            (Names{"b_1.mcap", "b 0.mcap", "c"}));
  EXPECT_EQ(files_of_bag("relative_file_paths: [a.db3, \"b.db3\"]\nx: y"), (Names{"a.db3", "b.db3"}));
  EXPECT_EQ(files_of_bag("relative_file_paths: []"), Names{});
  EXPECT_EQ(files_of_bag("relative_file_paths: ["), Names{});
  EXPECT_EQ(files_of_bag("relative_file_paths:"), Names{});
  EXPECT_EQ(files_of_bag("relative_file_paths:\n- a\n- b"), (Names{"a", "b"}));
  EXPECT_EQ(files_of_bag(""), Names{});
}

}  // namespace
}  // namespace scanknit::test
