#include "export/glb/glb_container.h"

#include <fmt/format.h>

#include <cstdint>
#include <span>

#include "core/files/byte_reader.h"
#include "export/mesh/mesh_builder.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kMagic = 0x46546C67;   // "glTF"
constexpr std::uint32_t kJson = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinary = 0x004E4942;  // "BIN"

/// The deepest nesting of brackets outside strings; needs no valid JSON.
int nesting_depth(std::string_view json) {
  int depth = 0;
  int deepest = 0;
  bool is_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (is_string) {
      if (c == '\\') ++i;
      is_string = c != '"';
    } else if (c == '"') {
      is_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

Result<void> check_glb_container(std::string_view bytes, int max_depth) {
  ByteReader reader(std::as_bytes(std::span(bytes)));
  const auto magic = reader.little_endian<std::uint32_t>();
  const auto version = reader.little_endian<std::uint32_t>();
  const auto length = reader.little_endian<std::uint32_t>();
  if (magic != kMagic || version != 2u || !length) return input_error("not a GLB file of version 2");
  if (*length != bytes.size()) {
    return input_error(
        fmt::format("truncated: the GLB header speaks of {} bytes, there are {}", *length, bytes.size()));
  }
  const auto json_length = reader.little_endian<std::uint32_t>();
  if (reader.little_endian<std::uint32_t>() != kJson) return input_error("a GLB file without a JSON chunk");
  const std::size_t json_begin = reader.offset();
  if (!reader.take(*json_length)) return input_error("truncated: the GLB's JSON chunk is longer than the file");
  if (nesting_depth(bytes.substr(json_begin, *json_length)) > max_depth) {
    return input_error(fmt::format("the GLB's JSON is nested deeper than {} levels", max_depth));
  }
  while (reader.remaining() > 0) {
    const auto chunk_length = reader.little_endian<std::uint32_t>();
    if (!reader.little_endian<std::uint32_t>() || !reader.take(*chunk_length)) {
      return input_error("truncated: a chunk of the GLB is longer than the file");
    }
  }
  return {};
}

GlbShell glb_shell(std::string json, std::size_t binary_bytes) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  const auto padding = [](std::size_t bytes) { return (4 - bytes % 4) % 4; };
  json.append(padding(json.size()), ' ');
  GlbShell shell{"", std::string(padding(binary_bytes), '\0')};
  binary_bytes += shell.after.size();
  const auto put = [&shell](std::size_t value) {
    for (int shift = 0; shift < 32; shift += 8) shell.before += static_cast<char>(value >> shift & 0xFF);
  };
  put(kMagic);
  put(2);
  put(kHeader + kChunkHeader + json.size() + kChunkHeader + binary_bytes);
  put(json.size());
  put(kJson);
  shell.before += json;
  put(binary_bytes);
  put(kBinary);
  return shell;
}

std::string glb_container(std::string json, std::string_view binary) {
  GlbShell shell = glb_shell(std::move(json), binary.size());
  std::string glb = std::move(shell.before);
  glb.reserve(glb.size() + binary.size() + shell.after.size());
  return glb.append(binary).append(shell.after);
}

}  // namespace scanknit
