#include "core/files/ply_header.h"

#include <array>
#include <utility>

#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

Error input_error(std::string what) {
  return {ErrorCode::kInput, std::move(what)};
}

constexpr std::size_t kMaxHeaderBytes = 1u << 16;  // real ones have less than 2 KiB

struct TypeName {
  std::string_view name;
  PlyType type;
};
constexpr std::array<TypeName, 16> kTypeNames = {{{"char", PlyType::kInt8},
                                                  {"int8", PlyType::kInt8},
                                                  {"uchar", PlyType::kUint8},
                                                  {"uint8", PlyType::kUint8},
                                                  {"short", PlyType::kInt16},
                                                  {"int16", PlyType::kInt16},
                                                  {"ushort", PlyType::kUint16},
                                                  {"uint16", PlyType::kUint16},
                                                  {"int", PlyType::kInt32},
                                                  {"int32", PlyType::kInt32},
                                                  {"uint", PlyType::kUint32},
                                                  {"uint32", PlyType::kUint32},
                                                  {"float", PlyType::kFloat32},
                                                  {"float32", PlyType::kFloat32},
                                                  {"double", PlyType::kFloat64},
                                                  {"float64", PlyType::kFloat64}}};

std::optional<PlyType> type_named(std::string_view name) {
  for (const TypeName& known : kTypeNames) {
    if (known.name == name) return known.type;
  }
  return std::nullopt;
}

std::optional<PlyEncoding> encoding_named(std::string_view name) {
  if (name == "ascii") return PlyEncoding::kAscii;
  if (name == "binary_little_endian") return PlyEncoding::kLittleEndian;
  if (name == "binary_big_endian") return PlyEncoding::kBigEndian;
  return std::nullopt;
}

std::optional<PlyProperty> parse_property(std::string_view words) {
  std::string_view type_word = take_word(words);
  std::optional<PlyType> count_type;
  if (type_word == "list") {
    count_type = type_named(take_word(words));
    if (!count_type) return std::nullopt;
    type_word = take_word(words);
  }
  const auto type = type_named(type_word);
  const std::string_view name = take_word(words);
  if (!type || name.empty()) return std::nullopt;
  return PlyProperty{std::string(name), *type, count_type};
}

/// One header line after "ply"; `error` says what is wrong with it.
Result<void> parse_line(std::string_view line, PlyHeader& header, bool& has_format) {
  std::string_view words = line;
  const std::string_view keyword = take_word(words);
  if (keyword == "comment" || keyword.empty()) return {};
  if (keyword == "obj_info") {
    header.obj_info.emplace_back(words);
    return {};
  }
  if (keyword == "format") {
    const auto encoding = encoding_named(take_word(words));
    if (!encoding) return input_error("PLY header: unknown format");
    header.encoding = *encoding;
    has_format = true;
    return {};
  }
  if (keyword == "element") {
    const std::string_view name = take_word(words);
    const auto count = parse_integer(take_word(words));
    if (name.empty() || !count || *count < 0) return input_error("PLY header: an element without a name and a count");
    header.elements.push_back({std::string(name), static_cast<std::size_t>(*count), {}});
    return {};
  }
  if (keyword == "property") {
    auto property = parse_property(words);
    if (!property || header.elements.empty()) return input_error("PLY header: a property that cannot be understood");
    header.elements.back().properties.push_back(std::move(*property));
    return {};
  }
  return input_error("PLY header: unknown keyword");
}

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8: return 1;
    case PlyType::kInt16:
    case PlyType::kUint16: return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32: return 4;
    case PlyType::kFloat64: return 8;
  }
  return 1;
}

std::size_t PlyElement::min_bytes(PlyEncoding encoding) const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    // In ASCII a number takes a digit; the blank after it may be missing at the end of the file.
    bytes += encoding == PlyEncoding::kAscii ? 1 : size_of(property.count_type.value_or(property.type));
  }
  return bytes;
}

Result<PlyHeader> parse_ply_header(std::string_view bytes) {
  std::string_view rest = bytes.substr(0, kMaxHeaderBytes);
  const std::size_t visible = rest.size();
  if (take_line(rest) != "ply") return input_error("not a PLY file: it does not begin with 'ply'");
  PlyHeader header;
  bool has_format = false;
  while (!rest.empty()) {
    const std::string_view line = take_line(rest);
    if (line == "end_header") {
      header.body_offset = visible - rest.size();
      if (!has_format) return input_error("PLY header: no format");
      return header;
    }
    if (auto parsed = parse_line(line, header, has_format); !parsed) return parsed.error();
  }
  return input_error("PLY header: no 'end_header'");
}

}  // namespace scanknit
