#include "acquire/pcl/pcd_header.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "acquire/replay/text_numbers.h"
#include "core/checked_math.h"
#include "core/files/ascii_numbers.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::size_t kMaxHeaderBytes = 4096;
constexpr std::size_t kMaxFields = 64;
constexpr std::size_t kMaxCount = 1024;  // the longest descriptor of PCL has 640 elements

Error broken(const std::string& what) {
  return {ErrorCode::kInput, "PCD: " + what};
}

std::optional<std::size_t> parse_size(std::string_view word, std::size_t max) {
  const auto number = parse_double(word);
  if (!number || !(*number >= 0) || *number > static_cast<double>(max)) return std::nullopt;
  const auto size = static_cast<std::size_t>(*number);
  return static_cast<double>(size) == *number ? std::optional(size) : std::nullopt;
}

// The lines up to DATA, as text; nothing when there is no such line near the front.
std::optional<std::string> header_text(std::span<const std::byte> bytes) {
  std::string text;
  std::size_t line_begin = 0;
  for (std::size_t i = 0; i < std::min(bytes.size(), kMaxHeaderBytes); ++i) {
    const char c = static_cast<char>(bytes[i]);
    text.push_back(c);
    if (c != '\n') continue;
    if (std::string_view(text).substr(line_begin).starts_with("DATA")) return text;
    line_begin = text.size();
  }
  return std::nullopt;
}

Result<void> parse_field_line(const TextLine& line, PcdHeader& header) {
  const std::string_view key = line.words[0];
  const std::size_t count = line.words.size() - 1;
  if (key == "FIELDS") {
    if (count == 0 || count > kMaxFields) return broken("FIELDS names none or too many");
    for (std::size_t i = 0; i < count; ++i) header.fields.push_back({.name = std::string(line.words[i + 1])});
    return {};
  }
  if (count != header.fields.size()) return broken(std::string(key) + " does not match FIELDS");
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view word = line.words[i + 1];
    PcdField& field = header.fields[i];
    if (key == "TYPE") {
      if (word != "I" && word != "U" && word != "F") return broken("TYPE is not I, U or F");
      field.type = word[0];
      continue;
    }
    const auto size = parse_size(word, key == "SIZE" ? 8 : kMaxCount);
    if (!size || *size == 0) return broken(std::string(key) + " is out of range");
    if (key == "SIZE" && *size != 1 && *size != 2 && *size != 4 && *size != 8) return broken("SIZE is not 1, 2, 4, 8");
    (key == "SIZE" ? field.size : field.count) = *size;
  }
  return {};
}

Result<void> parse_line(const TextLine& line, const Limits& limits, PcdHeader& header, std::size_t& points) {
  const std::string_view key = line.words[0];
  const auto max_pixels = static_cast<std::size_t>(limits.max_image_pixels);
  if (key == "VERSION") return {};
  if (key == "FIELDS" || key == "SIZE" || key == "TYPE" || key == "COUNT") return parse_field_line(line, header);
  if (key == "WIDTH" || key == "HEIGHT" || key == "POINTS") {
    const auto value = line.words.size() == 2 ? parse_size(line.words[1], max_pixels) : std::nullopt;
    if (!value) return broken(std::string(key) + " is not a number of at most " + std::to_string(max_pixels));
    if (key == "POINTS") points = *value;
    if (key == "WIDTH") header.width = static_cast<int>(*value);
    if (key == "HEIGHT") header.height = static_cast<int>(*value);
    return {};
  }
  if (key == "VIEWPOINT") {
    if (line.words.size() != 8) return broken("VIEWPOINT is not seven numbers");
    for (std::size_t i = 0; i < 7; ++i) {
      const auto number = parse_double(line.words[i + 1]);
      if (!number) return broken("VIEWPOINT is not seven numbers");
      header.viewpoint[i] = *number;
    }
    return {};
  }
  if (key == "DATA" && line.words.size() == 2) {
    const std::string_view encoding = line.words[1];
    if (encoding == "ascii") return header.encoding = PcdEncoding::kAscii, Result<void>();
    if (encoding == "binary") return header.encoding = PcdEncoding::kBinary, Result<void>();
    if (encoding == "binary_compressed") return header.encoding = PcdEncoding::kBinaryCompressed, Result<void>();
  }
  return broken("unknown line '" + std::string(key) + "'");
}

// Whether the bytes after the header hold width * height points.
Result<void> check_body(std::span<const std::byte> body, const PcdHeader& header) {
  const auto points = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
  const auto binary_bytes = checked_mul(points, header.point_bytes);
  if (!binary_bytes) return broken("more points than fit");
  if (header.encoding == PcdEncoding::kBinary) {
    return body.size() >= *binary_bytes ? Result<void>() : Result<void>(broken("truncated"));
  }
  if (header.encoding == PcdEncoding::kAscii) {
    const auto lines = static_cast<std::size_t>(std::count(body.begin(), body.end(), std::byte{'\n'}));
    const bool has_last = !body.empty() && body.back() != std::byte{'\n'};
    return lines + (has_last ? 1 : 0) >= points ? Result<void>() : Result<void>(broken("truncated"));
  }
  ByteReader reader(body);
  const auto compressed = reader.little_endian<std::uint32_t>();
  const auto uncompressed = reader.little_endian<std::uint32_t>();
  if (!compressed || !uncompressed || *compressed > reader.remaining()) return broken("truncated");
  if (*uncompressed != *binary_bytes) return broken("the compressed size does not match WIDTH, HEIGHT and FIELDS");
  return {};
}

}  // namespace

Result<PcdHeader> parse_pcd_header(std::span<const std::byte> bytes, const Limits& limits) {
  if (bytes.empty()) return Error{ErrorCode::kInput, "the file is empty"};
  const auto text = header_text(bytes);
  if (!text) return broken("not a PCD file: no DATA line near its front");
  PcdHeader header;
  header.header_bytes = text->size();
  std::size_t points = 0;
  for (const TextLine& line : text_lines(*text)) {
    if (const auto parsed = parse_line(line, limits, header, points); !parsed) return parsed.error();
  }
  if (header.fields.empty() || header.width == 0 || header.height == 0)
    return broken("FIELDS, WIDTH or HEIGHT missing");
  const std::int64_t pixels = std::int64_t{header.width} * header.height;
  if (pixels > limits.max_image_pixels) return broken("more points than " + std::to_string(limits.max_image_pixels));
  if (points != 0 && static_cast<std::int64_t>(points) != pixels) return broken("POINTS is not WIDTH times HEIGHT");
  for (PcdField& field : header.fields) {
    field.offset = header.point_bytes;
    header.point_bytes += field.size * field.count;
  }
  if (const auto checked = check_body(bytes.subspan(header.header_bytes), header); !checked) return checked.error();
  return header;
}

}  // namespace scanknit
