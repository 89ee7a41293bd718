// Bags of many gigabytes are opened without reading their pictures.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <ctime>

#include "acquire/bag/bag_messages.h"
#include "acquire/raw/raw_recording.h"
#include "db3_bag.h"
#include "ros1_bag.h"
#include "ros2_bag.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

// Sanitizers, which clang's builds are for, take time of their own.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || defined(__clang__)
constexpr double kSlowness = 20;
#else
constexpr double kSlowness = 1;
#endif

/// Counts what is read of a file in memory.
class CountedAccess final : public RandomAccess {
 public:
  CountedAccess(std::span<const std::byte> bytes, std::uint64_t& count) : bytes_(bytes), count_(count) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] bool read(std::uint64_t offset, std::span<std::byte> to) const override {
    count_ += to.size();
    return bytes_.read(offset, to);
  }

 private:
  MemoryAccess bytes_;
  std::uint64_t& count_;
};

constexpr int kLargeSide = 200;

/// Of 50 frames of 80 kB.
Ros2Bag large_bag(bool is_ros1) {
  const Ros2Writer ros{true, is_ros1};
  Ros2Bag bag;
  bag.add("/d/camera_info", kCameraType, 1, ros.camera(kLargeSide, kLargeSide, {200, 200, 99, 99}));
  for (std::int64_t i = 1; i <= 50; ++i) {
    bag.add(
        "/d/image", kImageType, i * 33'000'000,
        ros.image(i * 33'000'000, "d", "16UC1", kLargeSide, kLargeSide, counted_depth(1000, kLargeSide * kLargeSide)));
  }
  return bag;
}

// Three pictures of a topic are read to know what they are; a chunk is read whole where a message of it is.
TEST(LargeBag, IsOpenedWithoutItsPictures) {
  const auto expect_little = [](const Bytes& file, auto index) {
    std::uint64_t count = 0;
    const auto recording = index(std::make_unique<CountedAccess>(file, count), "bag", AcquireConfig{});
    ASSERT_TRUE(recording) << recording.error().text();
    EXPECT_EQ(recording->entries.size(), 50u);
    EXPECT_LT(count, file.size() / 8);
  };
  expect_little(large_bag(false).file(BagPacking::kNoChunk), index_ros2);
  if (const auto file = db3_file(large_bag(false).log())) expect_little(*file, index_ros2);
  std::vector<Bytes> chunks;
  const Ros2Bag of_ros1 = large_bag(true);
  for (const Ros2Bag::Logged& message : of_ros1.log()) {
    const bool is_camera = message.topic == "/d/camera_info";
    chunks.emplace_back();
    append_connection(chunks.back(), is_camera ? 1 : 2, message.topic,
                      is_camera ? "sensor_msgs/CameraInfo" : "sensor_msgs/Image");
    append_message(chunks.back(), is_camera ? 1 : 2, static_cast<double>(message.log_ns) * 1e-9, message.data);
  }
  expect_little(bag_of(chunks, "none"), index_ros1);
}

/// A file of 20 GB whose pictures are holes.
void write_sparse_bag(const fs::path& path, std::uint64_t size) {
  constexpr std::uint32_t kWidth = 1000, kHeight = 400;
  const Ros2Writer ros;
  Ros2Bag camera;
  camera.add("/d/camera_info", kCameraType, 1, ros.camera(kWidth, kHeight, {500, 500, 500, 200}));
  camera.add("/d/image", kImageType, 1, ros.image(1, "d", "16UC1", kWidth, kHeight, Bytes(kWidth * kHeight * 2)));
  Bytes file = camera.file(BagPacking::kNoChunk);
  constexpr std::size_t kEnd = 9 + 4 + 8;  // the record that ends the data, and the magic
  file.resize(file.size() - kEnd);
  const int descriptor = ::open(path.c_str(), O_CREAT | O_WRONLY, 0600);
  ASSERT_GE(descriptor, 0);
  ASSERT_EQ(::pwrite(descriptor, file.data(), file.size(), 0), static_cast<ssize_t>(file.size()));
  const Bytes image = ros.image(2, "d", "16UC1", kWidth, kHeight, Bytes(kWidth * kHeight * 2));
  const std::size_t head = image.size() - std::size_t{kWidth} * kHeight * 2;
  std::uint64_t at = file.size();
  for (std::uint64_t i = 2; at + image.size() < size; ++i) {
    Bytes record;
    ByteAppender writer(record);
    writer.little_endian(static_cast<std::uint8_t>(McapOp::kMessage));
    writer.little_endian(std::uint64_t{kMcapMessageHeader + image.size()});
    writer.little_endian(std::uint16_t{2});
    writer.little_endian(std::uint32_t{0});
    writer.little_endian(i * 1'000'000);
    writer.little_endian(i * 1'000'000);
    writer.append(std::span(image).first(head));
    ASSERT_EQ(::pwrite(descriptor, record.data(), record.size(), static_cast<off_t>(at)),
              static_cast<ssize_t>(record.size()));
    at += record.size() + image.size() - head;
  }
  ASSERT_EQ(::ftruncate(descriptor, static_cast<off_t>(size)), 0);
  ::close(descriptor);
}

TEST(LargeBag, OfTwentyGigabytesIsOpenedInTwoSeconds) {
  constexpr std::uint64_t kSize = 20'000'000'000;
  const TemporaryFolder folder;
  const fs::path path = folder / "bag.mcap";
  write_sparse_bag(path, kSize);
  const std::clock_t begin = std::clock();
  const auto source = open_recording(path, {});
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_GT((*source)->info().frames, 24'000u);
  EXPECT_TRUE(contains((*source)->info().warnings.at(0), "the bag is torn")) << "it has no end";
  EXPECT_LT(seconds, 2 * kSlowness) << "of the processor";
}

TEST(LargeBag, WhoseEndIsAHoleIsOpenedAtOnce) {
  const TemporaryFolder folder;
  const fs::path path = folder / "bag.mcap";
  Bytes file = robot_bag().file();
  file.resize(file.size() - 21);
  write_bytes(path, file);
  fs::resize_file(path, 20'000'000'000);
  const std::clock_t begin = std::clock();
  const auto source = open_recording(path, {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().frames, 2u);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 1 * kSlowness) << "holes are not searched";
}

}  // namespace
}  // namespace scanknit::test
