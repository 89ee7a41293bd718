// Bags with compressed chunks are opened by their index, and as if there were none where it is wrong.
#include <gtest/gtest.h>

#include "acquire/bag/bag_messages.h"
#include "acquire/raw/raw_recording.h"
#include "ros2_bag.h"

namespace scanknit::test {
namespace {

constexpr int kSide = 8;

Ros2Bag small_bag() {
  const Ros2Writer ros;
  Ros2Bag bag;
  bag.add("/d/camera_info", "sensor_msgs/msg/CameraInfo", 1, ros.camera(kSide, kSide, {9, 9, 3, 3}));
  for (std::int64_t i = 1; i <= 5; ++i) {
    const std::int64_t time_ns = i * 30'000'000;
    bag.add("/tf", "tf2_msgs/msg/TFMessage", time_ns,
            ros.transform(time_ns, "map", "d", {0.1 * static_cast<double>(i), 0, 0, 0, 0, 0, 1}));
    bag.add("/d/image", "sensor_msgs/msg/Image", time_ns + 5,
            ros.image(time_ns, "d", "16UC1", kSide, kSide, Bytes(kSide * kSide * 2, static_cast<std::byte>(i))));
  }
  return bag;
}

/// A bag as rosbag2 writes it: chunks of three messages, each with its message indexes, and a summary.
class IndexedFile {
 public:
  explicit IndexedFile(const Ros2Bag& bag) {
    bytes_.assign(kMcapMagic.begin(), kMcapMagic.end());
    record(McapOp::kHeader, bytes_, [](ByteAppender& writer) {
      writer.text("ros2");
      writer.text("");
    });
    Bytes records;
    std::map<std::uint16_t, Bytes> indexes;
    std::size_t waiting = 0;
    for (const Ros2Bag::Logged& message : bag.log()) {
      const auto [channel, is_new] = ids_.try_emplace(message.topic, static_cast<std::uint16_t>(ids_.size() + 1));
      const std::uint16_t id = channel->second;
      if (is_new) {
        for (Bytes* to : {&records, &summary_}) {
          append_schema({id, message.type, "ros2msg", ""}, *to);
          append_channel({id, id, message.topic, "cdr"}, *to);
        }
      }
      ByteAppender index(indexes[id]);
      index.little_endian(static_cast<std::uint64_t>(message.log_ns));
      index.little_endian(std::uint64_t{records.size()});
      ++counts_[id];
      record(McapOp::kMessage, records, [&](ByteAppender& writer) {
        writer.little_endian(id);
        writer.little_endian(std::uint32_t{0});
        writer.little_endian(static_cast<std::uint64_t>(message.log_ns));
        writer.little_endian(static_cast<std::uint64_t>(message.log_ns));
        writer.append(message.data);
      });
      if (++waiting % 3 == 0) end_chunk(records, indexes);
    }
    end_chunk(records, indexes);
    finish();
  }

  [[nodiscard]] const Bytes& bytes() const { return bytes_; }
  /// Of the bytes that are part of an index.
  [[nodiscard]] const std::vector<std::size_t>& index_bytes() const { return index_bytes_; }

 private:
  template <typename Fill>
  static void record(McapOp op, Bytes& bytes, const Fill& fill) {
    McapRecord opened(op, bytes);
    ByteAppender writer(bytes);
    fill(writer);
    opened.close();
  }

  void end_chunk(Bytes& records, std::map<std::uint16_t, Bytes>& indexes) {
    if (records.empty()) return;
    const std::uint64_t begin = bytes_.size();
    const Bytes packed = zstd_pack(records);
    record(McapOp::kChunk, bytes_, [&](ByteAppender& writer) {
      writer.append(Bytes(16));  // its times
      writer.little_endian(std::uint64_t{records.size()});
      writer.little_endian(crc32(records));
      writer.text("zstd");
      writer.little_endian(std::uint64_t{packed.size()});
      writer.append(packed);
    });
    const std::uint64_t end = bytes_.size();
    Bytes places;
    for (const auto& [id, index] : indexes) {
      ByteAppender(places).little_endian(id);
      ByteAppender(places).little_endian(std::uint64_t{bytes_.size()});
      record(McapOp::kMessageIndex, bytes_, [&, id = id, &index = index](ByteAppender& writer) {
        writer.little_endian(id);
        writer.little_endian(static_cast<std::uint32_t>(index.size()));
        writer.append(index);
      });
    }
    for (std::size_t i = end; i < bytes_.size(); ++i) index_bytes_.push_back(i);
    record(McapOp::kChunkIndex, chunk_indexes_, [&](ByteAppender& writer) {
      writer.append(Bytes(16));
      writer.little_endian(begin);
      writer.little_endian(end - begin);
      writer.little_endian(static_cast<std::uint32_t>(places.size()));
      writer.append(places);
      writer.little_endian(std::uint64_t{bytes_.size()} - end);
      writer.text("zstd");
      writer.little_endian(std::uint64_t{packed.size()});
      writer.little_endian(std::uint64_t{records.size()});
    });
    records.clear();
    indexes.clear();
  }

  void finish() {
    record(McapOp::kDataEnd, bytes_, [](ByteAppender& writer) { writer.little_endian(std::uint32_t{0}); });
    const std::uint64_t begin = bytes_.size();
    record(McapOp::kStatistics, summary_, [&](ByteAppender& writer) {
      writer.append(Bytes(8 + 2 + 4 + 4 + 4 + 4 + 8 + 8));
      writer.little_endian(static_cast<std::uint32_t>(counts_.size() * 10));
      for (const auto& [id, count] : counts_) {
        writer.little_endian(id);
        writer.little_endian(count);
      }
    });
    ByteAppender(summary_).append(chunk_indexes_);
    ByteAppender(bytes_).append(summary_);
    // Without a CRC, so that bytes of the summary can be changed and are still believed.
    record(McapOp::kFooter, bytes_, [&](ByteAppender& writer) {
      writer.little_endian(begin);
      writer.append(Bytes(8 + 4));
    });
    for (std::size_t i = begin; i < bytes_.size(); ++i) index_bytes_.push_back(i);
    ByteAppender(bytes_).append(kMcapMagic);
  }

  Bytes bytes_, summary_, chunk_indexes_;
  std::map<std::string, std::uint16_t> ids_;
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::vector<std::size_t> index_bytes_;
};

/// All that a bag gives, as text.
std::string content_of(const Bytes& file, McapIndexUse use) {
  auto reader = McapReader::open(std::make_unique<MemoryAccess>(file), {}, use);
  if (!reader) return reader.error().text();
  const auto recording = index_bag(messages_of_mcap(*std::move(reader), {}), "bag", {});
  if (!recording) return recording.error().text();
  std::string text;
  for (const auto& [key, topic] : recording->topics) text += key + "=" + topic + "\n";
  for (const std::string& warning : recording->warnings) text += warning + "\n";
  for (const FrameEntry& entry : recording->entries) {
    text += std::to_string(entry.timestamp_ns.value_or(-1)) + " ";
    if (entry.T_world_camera && *entry.T_world_camera) {
      text += std::to_string((*entry.T_world_camera)->translation().x()) + " ";
    }
    const auto decoded = recording->decode(entry, {});
    const auto* frame = std::get_if<DecodedFrame>(&decoded);
    text += frame != nullptr ? std::to_string(frame->depth_m.pixels()[0]) : std::get<Drop>(decoded).error.message;
    text += "\n";
  }
  return text;
}

TEST(BagIndex, GivesWhatTheChunksGive) {
  const IndexedFile file(small_bag());
  const std::string expected = content_of(small_bag().file(BagPacking::kZstd), McapIndexUse::kNone);
  EXPECT_NE(expected.find("0.500000"), std::string::npos) << expected;
  EXPECT_EQ(content_of(file.bytes(), McapIndexUse::kNone), expected);
  EXPECT_EQ(content_of(file.bytes(), McapIndexUse::kPacked), expected);
}

TEST(BagIndex, SparesUnpackingWhenABagIsOpened) {
  const IndexedFile file(small_bag());
  const auto reader = McapReader::open(std::make_unique<MemoryAccess>(file.bytes()), {}, McapIndexUse::kPacked);
  ASSERT_TRUE(reader) << reader.error().text();
  EXPECT_EQ(reader->messages().size(), 11u);
  EXPECT_GT(reader->indexed_bytes(), 0u);
  const Bytes without = small_bag().file(BagPacking::kZstd);
  const auto other = McapReader::open(std::make_unique<MemoryAccess>(without), {}, McapIndexUse::kPacked);
  ASSERT_TRUE(other) << other.error().text();
  EXPECT_EQ(other->indexed_bytes(), 0u);
}

// Whatever the index says, what comes is what comes without it.
TEST(BagIndex, IsNotBelievedWhereItIsWrong) {
  const IndexedFile file(small_bag());
  for (const std::size_t at : file.index_bytes()) {
    for (const auto change : {std::byte{1}, std::byte{0x80}}) {
      Bytes wrong = file.bytes();
      wrong[at] ^= change;
      ASSERT_EQ(content_of(wrong, McapIndexUse::kPacked), content_of(wrong, McapIndexUse::kNone)) << "byte " << at;
    }
  }
}

TEST(BagIndex, OfAFileThatIsCutOffIsNotNeeded) {
  const IndexedFile file(small_bag());
  for (std::size_t size = kMcapMagic.size(); size < file.bytes().size(); ++size) {
    const Bytes cut(file.bytes().begin(), file.bytes().begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_EQ(content_of(cut, McapIndexUse::kPacked), content_of(cut, McapIndexUse::kNone)) << "of " << size;
  }
}

}  // namespace
}  // namespace scanknit::test
