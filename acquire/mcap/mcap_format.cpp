#include "acquire/mcap/mcap_format.h"

#include "acquire/mcap/byte_appender.h"

namespace scanknit {

std::optional<std::string> take_mcap_text(ByteReader& reader) {
  const auto length = reader.little_endian<std::uint32_t>();
  if (!length) return std::nullopt;
  const auto bytes = reader.take(*length);
  if (!bytes) return std::nullopt;
  std::string text(bytes->size(), '\0');
  for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>((*bytes)[i]);
  return text;
}

McapRecord::McapRecord(McapOp op, std::vector<std::byte>& bytes) : bytes_(bytes) {
  ByteAppender writer(bytes_);
  writer.little_endian(static_cast<std::uint8_t>(op));
  writer.little_endian(std::uint64_t{0});
  content_at_ = bytes_.size();
}

void McapRecord::close() {
  ByteAppender(bytes_).put(content_at_ - sizeof(std::uint64_t), std::uint64_t{bytes_.size() - content_at_});
}

void append_schema(const McapSchema& schema, std::vector<std::byte>& bytes) {
  McapRecord record(McapOp::kSchema, bytes);
  ByteAppender writer(bytes);
  writer.little_endian(schema.id);
  writer.text(schema.name);
  writer.text(schema.encoding);
  writer.text(schema.text);
  record.close();
}

void append_channel(const McapChannel& channel, std::vector<std::byte>& bytes) {
  McapRecord record(McapOp::kChannel, bytes);
  ByteAppender writer(bytes);
  writer.little_endian(channel.id);
  writer.little_endian(channel.schema_id);
  writer.text(channel.topic);
  writer.text(channel.message_encoding);
  std::size_t metadata_bytes = 0;
  for (const auto& [key, value] : channel.metadata) metadata_bytes += 4 + key.size() + 4 + value.size();
  writer.little_endian(static_cast<std::uint32_t>(metadata_bytes));
  for (const auto& [key, value] : channel.metadata) {
    writer.text(key);
    writer.text(value);
  }
  record.close();
}

std::optional<McapSchema> parse_schema(std::span<const std::byte> content) {
  ByteReader reader(content);
  const auto id = reader.little_endian<std::uint16_t>();
  auto name = take_mcap_text(reader);
  auto encoding = take_mcap_text(reader);
  auto text = take_mcap_text(reader);
  if (!id || *id == 0 || !name || !encoding || !text) return std::nullopt;
  return McapSchema{*id, *std::move(name), *std::move(encoding), *std::move(text)};
}

std::optional<McapChannel> parse_channel(std::span<const std::byte> content) {
  ByteReader reader(content);
  const auto id = reader.little_endian<std::uint16_t>();
  const auto schema_id = reader.little_endian<std::uint16_t>();
  auto topic = take_mcap_text(reader);
  auto encoding = take_mcap_text(reader);
  if (!id || !schema_id || !topic || !encoding) return std::nullopt;
  return McapChannel{*id, *schema_id, *std::move(topic), *std::move(encoding)};
}

}  // namespace scanknit
