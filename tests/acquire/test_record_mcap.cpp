// The MCAP container: what is written is what the specification says, and no bytes can hurt the reader.
#include <gtest/gtest.h>

#include <map>

#include "acquire/mcap/byte_appender.h"
#include "acquire/mcap/mcap_reader.h"
#include "acquire/mcap/mcap_writer.h"
#include "acquire/mcap/zstd_bytes.h"
#include "core/files/byte_reader.h"
#include "core/files/crc32.h"

namespace scanknit::test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes text_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

ByteReader reader_at(const Bytes& bytes, std::size_t begin) {
  return ByteReader(std::span<const std::byte>(bytes).subspan(begin));
}
ByteReader reader_at(const Bytes& bytes, std::size_t begin, std::size_t length) {
  return ByteReader(std::span<const std::byte>(bytes).subspan(begin, length));
}

// Two channels, three chunks of three messages.
Bytes small_file(bool with_summary = true) {
  Bytes file;
  McapWriter writer(
      [&](std::span<const std::byte> bytes) {
        file.insert(file.end(), bytes.begin(), bytes.end());
        return Result<void>();
      },
      {{1, "thing", "jsonschema", "{}"}}, {{1, 1, "a", "json"}, {2, 1, "b", "json"}});
  EXPECT_TRUE(writer.begin());
  for (std::uint32_t i = 0; i < 9; ++i) {
    const Bytes data = text_bytes("message " + std::to_string(i));
    writer.add({.channel = static_cast<std::uint16_t>(1 + i % 2),
                .sequence = i,
                .log_ns = 1000 + i,
                .publish_ns = 500 + i,
                .data = data});
    if (i % 3 == 2) {
      EXPECT_TRUE(writer.flush());
    }
  }
  if (with_summary) {
    EXPECT_TRUE(writer.finish());
  }
  return file;
}

Result<McapReader> open(const Bytes& file, const Limits& limits = {}) {
  return McapReader::open(std::make_unique<MemoryAccess>(file), limits);
}

// Sequence number and data of every message that can be read.
std::map<std::uint32_t, Bytes> read_all(const Bytes& file) {
  std::map<std::uint32_t, Bytes> found;
  auto reader = open(file);
  if (!reader) return found;
  for (const McapMessagePlace& place : reader->messages()) {
    if (const auto data = reader->read(place)) found[place.sequence] = Bytes(data->begin(), data->end());
  }
  return found;
}

TEST(McapFile, GivesBackEveryMessageWithItsTimes) {
  const Bytes file = small_file();
  auto reader = open(file);
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->fault());
  ASSERT_EQ(reader->messages().size(), 9u);
  for (std::uint32_t i = 0; i < 9; ++i) {
    const McapMessagePlace& place = reader->messages()[i];
    EXPECT_EQ(place.sequence, i);
    EXPECT_EQ(place.channel, 1 + i % 2);
    EXPECT_EQ(place.log_ns, 1000 + i);
    EXPECT_EQ(place.publish_ns, 500 + i);
    const auto data = reader->read(place);
    ASSERT_TRUE(data);
    EXPECT_EQ(Bytes(data->begin(), data->end()), text_bytes("message " + std::to_string(i)));
  }
}

TEST(McapFile, NamesItsChannelsAndSchemas) {
  const auto reader = open(small_file());
  EXPECT_EQ(reader->channels(), (std::vector<McapChannel>{{1, 1, "a", "json"}, {2, 1, "b", "json"}}));
  EXPECT_EQ(reader->schemas(), (std::vector<McapSchema>{{1, "thing", "jsonschema", "{}"}}));
  EXPECT_EQ(reader->find_channel("b")->id, 2);
  EXPECT_EQ(reader->find_channel("c"), nullptr);
}

TEST(McapFile, IsReadWithoutItsSummary) {
  const Bytes file = small_file(false);
  EXPECT_EQ(read_all(file).size(), 9u);
  EXPECT_TRUE(open(file)->fault().has_value());
}

// The footer as a tool finds it: 8 + 20 + 9 bytes before the end. Its CRC covers the summary and its own first fields.
TEST(McapFile, EndsInASummaryThatItsChecksumCovers) {
  const Bytes file = small_file();
  const std::size_t footer = file.size() - kMcapMagic.size() - 20 - kMcapRecordHeader;
  ByteReader reader = reader_at(file, footer);
  EXPECT_EQ(reader.little_endian<std::uint8_t>(), 0x02);
  EXPECT_EQ(reader.little_endian<std::uint64_t>(), 20u);
  const auto summary = reader.little_endian<std::uint64_t>().value();
  const auto offsets = reader.little_endian<std::uint64_t>().value();
  const auto crc = reader.little_endian<std::uint32_t>().value();
  ASSERT_LT(summary, offsets);
  ASSERT_LT(offsets, footer);
  EXPECT_EQ(crc, crc32(std::span(file).subspan(summary, footer + kMcapRecordHeader + 16 - summary)));
  EXPECT_EQ(file[summary], std::byte{0x03});
  EXPECT_EQ(file[offsets], std::byte{0x0E});
}

struct Group {
  std::uint8_t op;
  std::uint64_t begin, length;
};

std::vector<Group> summary_groups(const Bytes& file) {
  ByteReader footer = reader_at(file, file.size() - kMcapMagic.size() - 20);
  (void)footer.little_endian<std::uint64_t>();
  ByteReader offsets = reader_at(file, footer.little_endian<std::uint64_t>().value());
  std::vector<Group> groups;
  while (offsets.little_endian<std::uint8_t>() == 0x0E) {
    (void)offsets.little_endian<std::uint64_t>();
    const auto op = offsets.little_endian<std::uint8_t>().value();
    const auto begin = offsets.little_endian<std::uint64_t>().value();
    groups.push_back({op, begin, offsets.little_endian<std::uint64_t>().value()});
  }
  return groups;
}

// What a tool that jumps would use: chunk indexes lead to chunks, their message indexes to message records.
TEST(McapFile, LeadsFromItsIndexToEveryMessage) {
  const Bytes file = small_file();
  std::size_t found = 0;
  for (const Group& group : summary_groups(file)) {
    if (group.op != 0x08) continue;
    ByteReader reader = reader_at(file, group.begin, group.length);
    while (reader.remaining() > 0) {
      (void)reader.take(kMcapRecordHeader + 16);
      const auto chunk = reader.little_endian<std::uint64_t>().value();
      const auto length = reader.little_endian<std::uint64_t>().value();
      EXPECT_EQ(file[chunk], std::byte{0x06});
      const std::size_t records = chunk + kMcapRecordHeader + 8 + 8 + 8 + 4 + 4 + 8;
      const auto map_bytes = reader.little_endian<std::uint32_t>().value();
      for (std::uint32_t i = 0; i < map_bytes / 10; ++i) {
        const auto channel = reader.little_endian<std::uint16_t>().value();
        ByteReader index = reader_at(file, reader.little_endian<std::uint64_t>().value());
        EXPECT_EQ(index.little_endian<std::uint8_t>(), 0x07);
        (void)index.little_endian<std::uint64_t>();
        EXPECT_EQ(index.little_endian<std::uint16_t>(), channel);
        const auto entries = index.little_endian<std::uint32_t>().value() / 16;
        for (std::uint32_t k = 0; k < entries; ++k) {
          const auto log_ns = index.little_endian<std::uint64_t>().value();
          ByteReader message = reader_at(file, records + index.little_endian<std::uint64_t>().value());
          EXPECT_EQ(message.little_endian<std::uint8_t>(), 0x05);
          (void)message.little_endian<std::uint64_t>();
          EXPECT_EQ(message.little_endian<std::uint16_t>(), channel);
          (void)message.little_endian<std::uint32_t>();
          EXPECT_EQ(message.little_endian<std::uint64_t>(), log_ns);
          ++found;
        }
      }
      (void)reader.take(8 + 4 + 8 + 8);  // index length, no compression, sizes
      EXPECT_GT(length, 0u);
    }
  }
  EXPECT_EQ(found, 9u);
}

TEST(McapFile, CutAtAnyByteKeepsEveryWholeChunk) {
  const Bytes file = small_file();
  std::vector<std::size_t> chunk_ends;
  for (const Group& group : summary_groups(file)) {
    if (group.op != 0x08) continue;
    ByteReader reader = reader_at(file, group.begin, group.length);
    while (reader.remaining() > 0) {
      (void)reader.take(kMcapRecordHeader + 16);
      const auto begin = reader.little_endian<std::uint64_t>().value();
      chunk_ends.push_back(begin + reader.little_endian<std::uint64_t>().value());
      const auto map_bytes = reader.little_endian<std::uint32_t>().value();
      (void)reader.take(map_bytes + 8 + 4 + 8 + 8);
    }
  }
  ASSERT_EQ(chunk_ends.size(), 3u);
  for (std::size_t size = 0; size < file.size(); ++size) {
    const auto whole = static_cast<std::size_t>(
        std::count_if(chunk_ends.begin(), chunk_ends.end(), [&](std::size_t end) { return end <= size; }));
    const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(read_all(cut).size(), 3 * whole) << size << " bytes";
  }
}

TEST(McapFile, NeverGivesAMessageWithAWrongByte) {
  const Bytes file = small_file();
  const auto truth = read_all(file);
  for (std::size_t i = 0; i < file.size(); ++i) {
    Bytes damaged = file;
    damaged[i] ^= std::byte{0x55};
    for (const auto& [sequence, data] : read_all(damaged)) {
      const auto expected = truth.find(sequence);
      ASSERT_TRUE(expected != truth.end() && expected->second == data) << "byte " << i;
    }
  }
}

TEST(McapFile, LosesOneChunkToOneWrongByteInItsRecords) {
  Bytes file = small_file();
  const Bytes needle = text_bytes("message 4");
  const auto at = std::search(file.begin(), file.end(), needle.begin(), needle.end());
  ASSERT_NE(at, file.end());
  *at ^= std::byte{1};
  EXPECT_EQ(read_all(file).size(), 6u);
}

// Its first byte is its kind, then come eight bytes of length.
std::size_t second_chunk(const Bytes& whole) {
  const auto is_chunk = [&](std::size_t at) {
    ByteReader reader = reader_at(whole, at);
    return reader.little_endian<std::uint8_t>() == 0x06 && reader.little_endian<std::uint64_t>().value_or(~0ull) < 1000;
  };
  std::size_t at = kMcapMagic.size(), chunks = 0;
  while (!is_chunk(at) || ++chunks < 2) {
    ByteReader reader = reader_at(whole, at);
    (void)reader.little_endian<std::uint8_t>();
    at += kMcapRecordHeader + reader.little_endian<std::uint64_t>().value();
  }
  return at;
}

// The specification: records of applications' own kinds, 0x80 and above, are passed over.
TEST(McapFile, PassesOverPrivateRecords) {
  Bytes file = small_file(false);
  const Bytes record = text_bytes(std::string("\x80\x05\0\0\0\0\0\0\0hello", 14));
  file.insert(file.begin() + static_cast<std::ptrdiff_t>(second_chunk(file)), record.begin(), record.end());
  EXPECT_EQ(read_all(file), read_all(small_file()));
  EXPECT_EQ(open(file)->fault().value_or("").find("damaged"), std::string::npos) << "it only lacks its end";
}

TEST(McapFile, SaysThatAChunkWithADamagedKindIsMissing) {
  Bytes file = small_file(false);
  file[second_chunk(file)] ^= std::byte{0x80};
  EXPECT_EQ(read_all(file).size(), 6u);
  EXPECT_NE(open(file)->fault().value_or("").find("damaged"), std::string::npos);
}

TEST(McapFile, LosesOneChunkToAWrongLength) {
  const Bytes whole = small_file();
  const std::size_t at = second_chunk(whole);
  for (const int change : {0x01, 0x10, 0xFF}) {
    for (std::size_t byte = 1; byte <= 8; ++byte) {
      Bytes file = whole;
      file[at + byte] ^= static_cast<std::byte>(change);
      const std::size_t messages = read_all(file).size();
      EXPECT_GE(messages, 6u) << "byte " << byte << " of the length, " << change;
      EXPECT_TRUE(messages == 9 || open(file)->fault()) << "what is missing is said";
    }
  }
}

TEST(McapFile, KeepsItsChannelsWhenTheFirstChunkIsDamaged) {
  Bytes file = small_file();
  const Bytes needle = text_bytes("thing");
  *std::search(file.begin(), file.end(), needle.begin(), needle.end()) ^= std::byte{1};
  const auto reader = open(file);
  EXPECT_EQ(reader->schemas().at(0).name, "thing");
  EXPECT_EQ(reader->channels().size(), 2u);
}

// As other tools write them.
TEST(McapFile, MayHaveChunksPackedWithZstd) {
  Bytes records;
  append_channel({1, 0, "a", "json"}, records);
  McapRecord message(McapOp::kMessage, records);
  ByteAppender(records).append(Bytes(kMcapMessageHeader + 5));
  message.close();
  Bytes file(kMcapMagic.begin(), kMcapMagic.end());
  McapRecord chunk(McapOp::kChunk, file);
  ByteAppender writer(file);
  writer.append(Bytes(16));
  writer.little_endian(std::uint64_t{records.size()});
  writer.little_endian(crc32(records));
  writer.text("zstd");
  const Bytes packed = zstd_pack(records);
  writer.little_endian(std::uint64_t{packed.size()});
  writer.append(packed);
  chunk.close();
  auto reader = open(file);
  ASSERT_TRUE(reader);
  ASSERT_EQ(reader->messages().size(), 1u);
  EXPECT_EQ(reader->read(reader->messages()[0])->size(), 5u);
}

TEST(McapFile, IsRefusedWhenItIsAnotherFile) {
  EXPECT_FALSE(open({}));
  EXPECT_FALSE(open(text_bytes("ply\nformat ascii 1.0\n")));
}

TEST(McapFile, WithMoreMessagesThanTheLimitIsRefused) {
  Limits limits;
  limits.max_frames = 8;
  EXPECT_FALSE(open(small_file(), limits));
  limits.max_frames = 9;
  EXPECT_TRUE(open(small_file(), limits));
}

TEST(McapFile, ReadsNoChunkBeyondTheLimits) {
  Limits limits;
  limits.max_image_bytes = 100;
  auto reader = open(small_file(), limits);
  ASSERT_TRUE(reader);
  for (const McapMessagePlace& place : reader->messages()) EXPECT_FALSE(reader->read(place));
}

}  // namespace
}  // namespace scanknit::test
