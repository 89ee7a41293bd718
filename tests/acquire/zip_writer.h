// Writes ZIP archives for tests: stored or deflated files, with the list at the end or without, with ZIP64 or without.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/mcap/byte_appender.h"

namespace scanknit::test {

class ZipWriter {
 public:
  using Bytes = std::vector<std::byte>;

  bool is_deflated = false;
  bool is_64 = false;  ///< sizes and places in fields of 64 bits
  std::uint16_t flags = 0;

  void add(const std::string& name, const Bytes& bytes) {
    const Bytes packed = is_deflated ? deflated(bytes) : bytes;
    const std::uint64_t at = archive.size();
    const Bytes sizes = extra({bytes.size(), packed.size()});
    put_file(archive, 0x04034b50, name, bytes, packed, sizes.size());
    append(archive, name);
    ByteAppender(archive).append(sizes);
    ByteAppender(archive).append(packed);
    const Bytes place = extra({bytes.size(), packed.size(), at});
    put_file(list_, 0x02014b50, name, bytes, packed, place.size());
    for (int i = 0; i < 5; ++i) ByteAppender(list_).little_endian(std::uint16_t{0});
    ByteAppender(list_).little_endian(is_64 ? kWide : static_cast<std::uint32_t>(at));
    append(list_, name);
    ByteAppender(list_).append(place);
    ++files_;
  }

  /// With the list of files.
  [[nodiscard]] Bytes whole(std::string_view comment = {}) const {
    Bytes bytes = archive;
    const std::uint64_t at = bytes.size();
    ByteAppender out(bytes);
    out.append(list_);
    const std::uint64_t at_64 = bytes.size();
    if (is_64) {
      for (const std::uint32_t value : {0x06064b50u, 44u, 0u, 0u, 0u, 0u}) out.little_endian(value);
      for (const std::uint64_t value : {files_, files_, std::uint64_t{list_.size()}, at}) out.little_endian(value);
      out.little_endian(std::uint32_t{0x07064b50});
      out.little_endian(std::uint32_t{0});
      out.little_endian(at_64);
      out.little_endian(std::uint32_t{1});
    }
    out.little_endian(std::uint32_t{0x06054b50});
    out.little_endian(std::uint32_t{0});
    for (int i = 0; i < 2; ++i) out.little_endian(static_cast<std::uint16_t>(files_));
    out.little_endian(is_64 ? kWide : static_cast<std::uint32_t>(list_.size()));
    out.little_endian(is_64 ? kWide : static_cast<std::uint32_t>(at));
    out.little_endian(static_cast<std::uint16_t>(comment.size()));
    append(bytes, comment);
    return bytes;
  }

  Bytes archive;  ///< the files alone

 private:
  static constexpr std::uint32_t kWide = 0xFFFFFFFF;

  static void append(Bytes& bytes, std::string_view text) {
    ByteAppender(bytes).append(std::as_bytes(std::span(text)));
  }
  [[nodiscard]] Bytes extra(const std::vector<std::uint64_t>& numbers) const {
    Bytes bytes;
    if (!is_64) return bytes;
    ByteAppender out(bytes);
    out.little_endian(std::uint16_t{1});
    out.little_endian(static_cast<std::uint16_t>(8 * numbers.size()));
    for (const std::uint64_t number : numbers) out.little_endian(number);
    return bytes;
  }
  void put_file(Bytes& to, std::uint32_t kind, const std::string& name, const Bytes& bytes, const Bytes& packed,
                std::size_t extra_bytes) const {
    ByteAppender out(to);
    out.little_endian(kind);
    out.little_endian(std::uint16_t{20});
    if (kind == 0x02014b50) out.little_endian(std::uint16_t{20});
    out.little_endian(flags);
    out.little_endian(static_cast<std::uint16_t>(is_deflated ? 8 : 0));
    out.little_endian(std::uint32_t{0});
    out.little_endian(static_cast<std::uint32_t>(
        crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), bytes.size())));
    out.little_endian(is_64 ? kWide : static_cast<std::uint32_t>(packed.size()));
    out.little_endian(is_64 ? kWide : static_cast<std::uint32_t>(bytes.size()));
    out.little_endian(static_cast<std::uint16_t>(name.size()));
    out.little_endian(static_cast<std::uint16_t>(extra_bytes));
  }
  static Bytes deflated(const Bytes& bytes) {
    Bytes packed(compressBound(bytes.size()) + 16);
    z_stream stream{};
    deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY);
    stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
  }

  Bytes list_;
  std::uint64_t files_ = 0;
};

/// An LZFSE stream of one block that is not packed.
[[nodiscard]] inline ZipWriter::Bytes plain_lzfse(const ZipWriter::Bytes& bytes) {
  ZipWriter::Bytes stream;
  ByteAppender out(stream);
  out.append(std::as_bytes(std::span(std::string_view("bvx-"))));
  out.little_endian(static_cast<std::uint32_t>(bytes.size()));
  out.append(bytes);
  out.append(std::as_bytes(std::span(std::string_view("bvx$"))));
  return stream;
}

}  // namespace scanknit::test
