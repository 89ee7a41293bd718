#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>

#include "core/files/ascii_numbers.h"
#include "core/files/byte_reader.h"
#include "export/mesh/mesh_builder.h"
#include "export/mesh/mesh_readers.h"

namespace scanknit {
namespace {

constexpr std::size_t kHeaderBytes = 84;  // 80 of free text, then the number of facets
constexpr std::size_t kFacetBytes = 50;   // normal, three corners, attribute

/// The facet count of the header, when the file is as long as that makes a binary STL. ASCII files begin with "solid",
/// but so do some binary ones: the length decides.
std::optional<std::size_t> binary_facets(std::string_view bytes) {
  ByteReader reader(std::as_bytes(std::span(bytes)));
  if (!reader.take(kHeaderBytes - sizeof(std::uint32_t))) return std::nullopt;
  const auto count = reader.little_endian<std::uint32_t>();
  if (!count || reader.remaining() != kFacetBytes * static_cast<std::size_t>(*count)) return std::nullopt;
  return *count;
}

Error too_many(const Limits& limits) {
  return input_error(fmt::format("more triangles than the limit of {}", limits.max_mesh_triangles));
}

Result<Mesh> read_binary(std::string_view bytes, std::size_t facets, const Limits& limits) {
  if (facets > limits.max_mesh_triangles || 3 * facets > std::numeric_limits<std::uint32_t>::max()) {
    return too_many(limits);
  }
  ByteReader reader(std::as_bytes(std::span(bytes.substr(kHeaderBytes))));
  std::vector<Eigen::Vector3f> soup;
  soup.reserve(3 * facets);
  for (std::size_t facet = 0; facet < facets; ++facet) {
    bool is_whole = reader.take(3 * sizeof(float)).has_value();  // the normal: the corners say it better
    for (int corner = 0; corner < 3; ++corner) {
      Eigen::Vector3f& p = soup.emplace_back();
      for (float& coordinate : p) {
        const auto value = reader.little_endian<float>();
        is_whole = is_whole && value.has_value();
        coordinate = value.value_or(0);
      }
    }
    is_whole = reader.take(sizeof(std::uint16_t)).has_value() && is_whole;
    if (!is_whole) return input_error("truncated");
  }
  return weld(soup);
}

Result<Mesh> read_ascii(std::string_view rest, const Limits& limits) {
  std::vector<Eigen::Vector3f> soup;
  bool is_closed = false;
  for (std::string_view line = take_line(rest); !line.empty() || !rest.empty(); line = take_line(rest)) {
    const std::string_view keyword = take_word(line);
    if (keyword == "endsolid") is_closed = true;
    if (keyword == "solid") is_closed = false;
    if (keyword != "vertex") continue;
    Eigen::Vector3f& p = soup.emplace_back();
    for (float& coordinate : p) {
      const auto value = parse_float(take_word(line));
      if (!value) return input_error("STL: a vertex that is not three numbers");
      coordinate = *value;
    }
    if (soup.size() / 3 > limits.max_mesh_triangles) return too_many(limits);
  }
  if (!is_closed || soup.size() % 3 != 0) return input_error("truncated: the STL text ends inside a solid");
  return weld(soup);
}

}  // namespace

Result<Mesh> read_stl(std::string_view bytes, const Limits& limits) {
  if (const auto facets = binary_facets(bytes)) return read_binary(bytes, *facets, limits);
  if (bytes.starts_with("solid")) return read_ascii(bytes, limits);
  return input_error(
      "not an STL file, or truncated: no 'solid' at its start, and its length is not 84 bytes and 50 a facet");
}

}  // namespace scanknit
