// LZFSE: streams that Apple's reference encoder made of what is computed here (tests/fuzz/corpus/lzfse).
#include <gtest/gtest.h>

#include "acquire/phones/lzfse.h"
#include "record3d_scene.h"
#include "test_replay_support.h"
#include "zip_writer.h"

namespace scanknit::test::lzfse {
namespace {

using Bytes = std::vector<std::byte>;

Bytes as_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Bytes noise() {
  Bytes bytes;
  std::uint32_t x = 1;
  for (int i = 0; i < 100; ++i) {
    x = (x * 1103515245u + 12345u) & 0x7FFFFFFFu;
    bytes.push_back(static_cast<std::byte>(x >> 16 & 0xFF));
  }
  return bytes;
}

Bytes lines() {
  std::string text;
  for (int i = 0; i < 200; ++i) text += "line " + std::to_string(i) + " of " + std::to_string(i * i % 97) + "\n";
  return as_bytes(text);
}

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

struct Stream {
  const char* name;
  Bytes unpacked;
};

/// Not packed, LZVN, LZFSE with packed tables and with plain ones, long matches, and blocks of three kinds.
std::vector<Stream> streams() {
  const Bytes depth = scene_depth_bytes(1000);
  return {{"plain", noise()}, {"lzvn", lines()},         {"fse2", depth},
          {"fse1", depth},    {"zeros", Bytes(300'000)}, {"mixed", joined({lines(), depth, noise()})}};
}

Bytes packed(const Stream& stream) {
  return bytes_of(std::filesystem::path(kSourceDir) / "tests/fuzz/corpus/lzfse" / stream.name);
}

TEST(Lzfse, UnpacksWhatTheReferenceEncoderMade) {
  for (const Stream& stream : streams()) {
    const auto unpacked = unpack_lzfse(packed(stream), stream.unpacked.size());
    ASSERT_TRUE(unpacked) << stream.name << ": " << unpacked.error().message;
    EXPECT_EQ(*unpacked, stream.unpacked) << stream.name;
  }
}

TEST(Lzfse, RefusesMoreThanTheLimit) {
  for (const Stream& stream : streams()) EXPECT_FALSE(unpack_lzfse(packed(stream), stream.unpacked.size() - 1));
}

TEST(Lzfse, CutAtAnyByteIsRefused) {
  for (const Stream& stream : streams()) {
    const Bytes whole = packed(stream);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      ASSERT_FALSE(unpack_lzfse(std::span(whole).first(size), stream.unpacked.size())) << stream.name << ' ' << size;
    }
  }
}

TEST(Lzfse, SurvivesAnyWrongByte) {
  for (const Stream& stream : streams()) {
    const Bytes whole = packed(stream);
    for (std::size_t i = 0; i < whole.size(); ++i) {
      for (const int change : {0x01, 0x80, 0xFF}) {
        Bytes damaged = whole;
        damaged[i] ^= static_cast<std::byte>(change);
        const auto unpacked = unpack_lzfse(damaged, stream.unpacked.size());
        EXPECT_TRUE(!unpacked || unpacked->size() <= stream.unpacked.size());
      }
    }
  }
}

/// A block of LZVN that is to become `count` bytes.
Bytes lzvn_block(std::uint32_t count, const std::vector<int>& instructions) {
  Bytes bytes = as_bytes("bvxn");
  ByteAppender out(bytes);
  out.little_endian(count);
  out.little_endian(static_cast<std::uint32_t>(instructions.size() + 8));
  for (const int byte : instructions) bytes.push_back(static_cast<std::byte>(byte));
  out.little_endian(std::uint64_t{6});  // the end of the instructions
  out.append(as_bytes("bvx$"));
  return bytes;
}

TEST(Lzfse, ReadsEveryInstructionOfLzvn) {
  // "abc" and 3 + 1 from 3 back; nothing; 1 literal and 3 from the same distance; 2 from there; 17 literals; 16 from
  // there; 1 literal and 3 from 4 back, the distance in 14 bits, and in 16.
  std::vector<int> instructions = {0xC8, 3, 'a', 'b', 'c', 0x0E, 0x46, 'd', 0xF2, 0xE0, 1};
  for (int i = 0; i < 17; ++i) instructions.push_back('A' + i);
  for (const int byte : {0xF0, 0, 0xA8, 4 << 2, 0, int{'x'}, 0x47, 4, 0, int{'y'}}) instructions.push_back(byte);
  const std::string expected = "abcabcadcadcaABCDEFGHIJKLMNOPQOPQOPQOPQOPQOPQOxPQOyPQO";
  const auto unpacked = unpack_lzfse(lzvn_block(static_cast<std::uint32_t>(expected.size()), instructions), 1000);
  ASSERT_TRUE(unpacked);
  std::string text;
  for (const std::byte b : *unpacked) text += static_cast<char>(b);
  EXPECT_EQ(text, expected);
}

TEST(Lzfse, RefusesWhatNoEncoderWrites) {
  EXPECT_FALSE(unpack_lzfse(as_bytes("none"), 100));
  EXPECT_FALSE(unpack_lzfse(as_bytes("bvx-\xFF\xFF\xFF\xFF"), 100)) << "4 GiB that are not there";
  EXPECT_FALSE(unpack_lzfse(lzvn_block(0xFFFFFFFF, {0xE1, 'a'}), 100)) << "4 GiB unpacked";
  EXPECT_TRUE(unpack_lzfse(lzvn_block(4, {0x40, 1, 'a'}), 100)) << "this one is whole: aaaa";
  EXPECT_FALSE(unpack_lzfse(lzvn_block(4, {0x40, 2, 'a'}), 100)) << "a match from before the start";
  EXPECT_FALSE(unpack_lzfse(lzvn_block(4, {0x40, 0, 'a'}), 100)) << "a match of itself";
  EXPECT_FALSE(unpack_lzfse(lzvn_block(4, {0x46, 'a'}), 100)) << "a distance before there is one";
  EXPECT_FALSE(unpack_lzfse(lzvn_block(5, {0x40, 1, 'a'}), 100)) << "less than it states";
  EXPECT_FALSE(unpack_lzfse(lzvn_block(3, {0x40, 1, 'a'}), 100)) << "more than it states";
  for (const int code : {0x1E, 0x26, 0x2E, 0x36, 0x3E, 0x70, 0x7F, 0xD0, 0xDF}) {
    EXPECT_FALSE(unpack_lzfse(lzvn_block(1, {0xE1, 'a', code}), 100)) << code;
  }
}

}  // namespace
}  // namespace scanknit::test::lzfse
