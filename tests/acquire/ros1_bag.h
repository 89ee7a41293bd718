// Bags of ROS 1 that tests write for themselves.
#pragma once

#include <bzlib.h>
#include <lz4frame.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/mcap/byte_appender.h"

namespace scanknit::test {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of_text(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

template <typename T>
inline std::string number_field(const std::string& name, T value) {
  Bytes raw;
  ByteAppender(raw).little_endian(value);
  std::string field = name + "=";
  for (const std::byte b : raw) field += static_cast<char>(b);
  return field;
}

inline void append_record(Bytes& bytes, const std::vector<std::string>& fields, const Bytes& data) {
  Bytes header;
  ByteAppender header_writer(header);
  for (const std::string& field : fields) header_writer.text(field);
  ByteAppender writer(bytes);
  writer.little_endian(static_cast<std::uint32_t>(header.size()));
  writer.append(header);
  writer.little_endian(static_cast<std::uint32_t>(data.size()));
  writer.append(data);
}

inline Bytes connection_data(const std::string& type) {
  Bytes data;
  ByteAppender(data).text("type=" + type);
  return data;
}

inline void append_message(Bytes& chunk, std::uint32_t connection, double seconds, const Bytes& data) {
  const auto whole = static_cast<std::uint64_t>(seconds);
  const auto rest = static_cast<std::uint64_t>((seconds - static_cast<double>(whole)) * 1e9 + 0.5);
  append_record(chunk,
                {number_field<std::uint8_t>("op", 2), number_field("conn", connection),
                 number_field<std::uint64_t>("time", rest << 32 | whole)},
                data);
}

inline void append_connection(Bytes& chunk, std::uint32_t id, const std::string& topic, const std::string& type) {
  append_record(chunk, {number_field<std::uint8_t>("op", 7), number_field("conn", id), "topic=" + topic},
                connection_data(type));
}

inline Bytes pack(const Bytes& bytes, const std::string& compression) {
  if (compression == "lz4") {
    Bytes packed(LZ4F_compressFrameBound(bytes.size(), nullptr));
    packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr));
    return packed;
  }
  if (compression != "bz2") return bytes;
  std::vector<char> source, target(bytes.size() + 1000);
  for (const std::byte b : bytes) source.push_back(static_cast<char>(b));
  auto size = static_cast<unsigned>(target.size());
  BZ2_bzBuffToBuffCompress(target.data(), &size, source.data(), static_cast<unsigned>(source.size()), 1, 0, 0);
  Bytes packed;
  for (unsigned i = 0; i < size; ++i) packed.push_back(static_cast<std::byte>(target[i]));
  return packed;
}

inline void append_chunk(Bytes& bag, const Bytes& chunk, const std::string& compression) {
  append_record(bag,
                {number_field<std::uint8_t>("op", 5), "compression=" + compression,
                 number_field("size", static_cast<std::uint32_t>(chunk.size()))},
                pack(chunk, compression));
}

// As far as a program has come that ends before it writes the index.
inline Bytes unfinished_bag(const std::vector<Bytes>& chunks, const std::string& compression,
                            std::uint64_t index_at = 0) {
  Bytes bag = bytes_of_text("#ROSBAG V2.0\n");
  const std::uint32_t indexed = index_at > 0 ? static_cast<std::uint32_t>(chunks.size()) : 0;
  append_record(bag,
                {number_field<std::uint8_t>("op", 3), number_field("index_pos", index_at),
                 number_field("conn_count", indexed > 0 ? 1u : 0u), number_field("chunk_count", indexed)},
                Bytes(100));
  for (const Bytes& chunk : chunks) append_chunk(bag, chunk, compression);
  return bag;
}

// The index: one of the connections again, and where each chunk is.
inline Bytes bag_of(const std::vector<Bytes>& chunks, const std::string& compression) {
  Bytes bag = unfinished_bag(chunks, compression, unfinished_bag(chunks, compression).size());
  append_connection(bag, 7, "/a", "std_msgs/String");
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    append_record(bag, {number_field<std::uint8_t>("op", 6), number_field("count", 1u)}, Bytes(8));
  }
  return bag;
}

}  // namespace scanknit::test
