#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/files/ply_numbers.h"
#include "export/mesh/mesh_builder.h"
#include "export/mesh/mesh_readers.h"

namespace scanknit {
namespace {

Error truncated(const PlyElement& element, std::size_t index) {
  return input_error(fmt::format("truncated or malformed in {} {} of {}", element.name, index, element.count));
}

/// What a vertex property means to us; the order is that of the names in `kSlotNames`.
constexpr std::array<std::string_view, 10> kSlotNames = {"x",  "y",   "z",     "nx",   "ny",
                                                         "nz", "red", "green", "blue", "uncertainty"};
constexpr std::size_t kUncertainty = 9;
constexpr std::size_t kSkipped = kSlotNames.size();

struct VertexLayout {
  std::vector<std::size_t> slots;  // of each property; kSkipped for what we do not use
  std::array<PlyType, kSlotNames.size()> type{};
  std::array<bool, kSlotNames.size()> has{};

  explicit VertexLayout(const PlyElement& element) {
    for (const PlyProperty& property : element.properties) {
      const auto found = std::find(kSlotNames.begin(), kSlotNames.end(), property.name);
      const auto slot = static_cast<std::size_t>(found - kSlotNames.begin());
      const bool is_used = slot != kSkipped && !property.count_type && !has[slot];
      slots.push_back(is_used ? slot : kSkipped);
      if (!is_used) continue;
      type[slot] = property.type;
      has[slot] = true;
    }
  }
  [[nodiscard]] bool has_triple(std::size_t first) const { return has[first] && has[first + 1] && has[first + 2]; }
};

/// Bytes are bytes, 16-bit channels 0..65535, floating-point channels 0..1.
std::uint8_t colour_byte(double value, PlyType type) {
  if (type == PlyType::kFloat32 || type == PlyType::kFloat64) value *= 255;
  if (type == PlyType::kUint16) value /= 257;  // 65535 / 255
  return value > 0 ? static_cast<std::uint8_t>(std::lround(std::min(value, 255.0))) : std::uint8_t{0};
}

Result<void> read_vertices(const PlyElement& element, PlyNumbers& numbers, Mesh& mesh, MeshNotes* notes) {
  const VertexLayout layout(element);
  if (!layout.has_triple(0)) return input_error("PLY vertices without x, y and z");
  const bool has_normals = layout.has_triple(3);
  const bool has_colours = layout.has_triple(6);
  const bool has_uncertainty = notes != nullptr && layout.has[kUncertainty];
  mesh.positions_m.reserve(element.count);
  if (has_normals) mesh.normals.reserve(element.count);
  if (has_colours) mesh.colours.reserve(element.count);
  if (has_uncertainty) notes->uncertainty_m.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    std::array<double, kSlotNames.size()> v{};
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (layout.slots[p] == kSkipped) {
        if (!numbers.skip(element.properties[p])) return truncated(element, i);
        continue;
      }
      const auto value = numbers.next(element.properties[p].type);
      if (!value) return truncated(element, i);
      v[layout.slots[p]] = *value;
    }
    mesh.positions_m.push_back(Eigen::Vector3d(v[0], v[1], v[2]).cast<float>());
    if (has_normals) mesh.normals.push_back(Eigen::Vector3d(v[3], v[4], v[5]).cast<float>());
    if (has_colours) {
      mesh.colours.push_back(
          {colour_byte(v[6], layout.type[6]), colour_byte(v[7], layout.type[7]), colour_byte(v[8], layout.type[8])});
    }
    if (has_uncertainty) notes->uncertainty_m.push_back(static_cast<float>(v[kUncertainty]));
  }
  return {};
}

bool is_corner_list(const PlyProperty& property) {
  return property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index");
}

Result<void> read_faces(const PlyElement& element, PlyNumbers& numbers, const Limits& limits, Mesh& mesh) {
  std::vector<std::uint32_t> corners;
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!is_corner_list(property)) {
        if (!numbers.skip(property)) return truncated(element, i);
        continue;
      }
      const auto count = numbers.next_count(property);
      if (!count) return truncated(element, i);
      corners.clear();
      for (std::size_t c = 0; c < *count; ++c) {
        const auto index = numbers.next(property.type);
        if (!index) return truncated(element, i);
        if (!(*index >= 0 && *index < 4294967295.0))
          return input_error(fmt::format("face {} names vertex {}", i, *index));
        corners.push_back(static_cast<std::uint32_t>(*index));
      }
      if (auto added = add_polygon(corners, limits, mesh); !added) return added;
    }
  }
  return {};
}

Result<void> skip_element(const PlyElement& element, PlyNumbers& numbers) {
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!numbers.skip(property)) return truncated(element, i);
    }
  }
  return {};
}

/// Believes an element's count only when the limits and the bytes that are left allow it.
Result<void> check_count(const PlyElement& element, PlyEncoding encoding, std::size_t remaining, const Limits& limits) {
  const std::size_t most = element.name == "vertex" ? limits.max_mesh_vertices : limits.max_mesh_triangles;
  if (element.count > most) {
    return input_error(fmt::format("{} {} elements, more than the limit of {}", element.count, element.name, most));
  }
  if (element.count > remaining / element.min_bytes(encoding)) {
    return input_error(
        fmt::format("truncated: {} bytes cannot hold {} {} elements", remaining, element.count, element.name));
  }
  return {};
}

}  // namespace

Result<Mesh> read_ply(std::string_view bytes, const Limits& limits, MeshNotes* notes) {
  const auto header = parse_ply_header(bytes);
  if (!header) return header.error();
  PlyNumbers numbers(bytes.substr(header->body_offset), header->encoding);
  Mesh mesh;
  bool has_vertices = false;
  for (const PlyElement& element : header->elements) {
    if (element.properties.empty() && element.name != "vertex") continue;  // takes no bytes, whatever its count
    if (element.properties.empty()) return input_error("PLY vertices without x, y and z");
    if (auto ok = check_count(element, header->encoding, numbers.remaining(), limits); !ok) return ok.error();
    Result<void> read;
    if (element.name == "vertex" && !has_vertices) {
      has_vertices = true;
      read = read_vertices(element, numbers, mesh, notes);
    } else if (element.name == "face") {
      read = read_faces(element, numbers, limits, mesh);
    } else {
      read = skip_element(element, numbers);
    }
    if (!read) return read.error();
  }
  if (!has_vertices) return input_error("PLY file without vertices");
  return mesh;
}

}  // namespace scanknit
