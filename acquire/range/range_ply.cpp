#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "acquire/range/estimate_sight.h"
#include "acquire/range/range_files.h"
#include "core/checked_math.h"
#include "core/files/ascii_numbers.h"
#include "core/files/ply_numbers.h"

namespace scanknit {
namespace {

constexpr const char* kGrid = "range_grid";

Error broken(const std::string& what) {
  return {ErrorCode::kInput, "range grid: " + what};
}

Error cut_short(const PlyElement& element, std::size_t index) {
  return broken("truncated or malformed in " + element.name + " " + std::to_string(index) + " of " +
                std::to_string(element.count) + "; is the file whole?");
}

const PlyElement* element_named(const PlyHeader& header, std::string_view name) {
  const auto found = std::find_if(header.elements.begin(), header.elements.end(),
                                  [&](const PlyElement& element) { return element.name == name; });
  return found == header.elements.end() ? nullptr : &*found;
}

struct GridSize {
  int columns, rows;
};

Result<GridSize> grid_size(const PlyHeader& header, const PlyElement& grid, const Limits& limits) {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  for (const std::string& info : header.obj_info) {
    std::string_view words = info;
    const std::string_view key = take_word(words);
    if (key != "num_cols" && key != "num_rows") continue;
    const auto value = parse_integer(take_word(words));
    if (!value || *value < 1) return broken("obj_info " + std::string(key) + " is not a whole number above 0");
    (key == "num_cols" ? columns : rows) = *value;
  }
  if (columns == 0 || rows == 0) return broken("no 'obj_info num_cols' or 'num_rows' in the header");
  const auto cells = checked_mul(columns, rows);
  if (!cells || *cells > limits.max_image_pixels) {
    return broken(std::to_string(columns) + " x " + std::to_string(rows) + " cells, more than the limit of " +
                  std::to_string(limits.max_image_pixels));
  }
  if (static_cast<std::size_t>(*cells) != grid.count) {
    return broken("num_cols x num_rows is " + std::to_string(*cells) + ", but the element has " +
                  std::to_string(grid.count) + " cells");
  }
  return GridSize{static_cast<int>(columns), static_cast<int>(rows)};
}

struct Vertices {
  std::vector<Eigen::Vector3f> points;
  std::vector<Rgb8> colours;
};

constexpr std::array<std::string_view, 6> kSlots = {"x", "y", "z", "red", "green", "blue"};

Result<Vertices> read_vertices(const PlyElement& element, PlyNumbers& numbers) {
  std::vector<std::size_t> slots;
  std::array<bool, kSlots.size()> has{};
  for (const PlyProperty& property : element.properties) {
    const auto slot = static_cast<std::size_t>(std::find(kSlots.begin(), kSlots.end(), property.name) - kSlots.begin());
    const bool is_byte = property.type == PlyType::kUint8;
    const bool is_used = slot < kSlots.size() && !property.count_type && !has[slot] && (slot < 3 || is_byte);
    slots.push_back(is_used ? slot : kSlots.size());
    if (is_used) has[slot] = true;
  }
  if (!has[0] || !has[1] || !has[2]) return broken("vertices without x, y and z");
  const bool has_colours = has[3] && has[4] && has[5];
  Vertices vertices;
  vertices.points.reserve(element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    std::array<double, kSlots.size()> v{};
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      if (slots[p] == kSlots.size()) {
        if (!numbers.skip(element.properties[p])) return cut_short(element, i);
        continue;
      }
      const auto value = numbers.next(element.properties[p].type);
      if (!value) return cut_short(element, i);
      v[slots[p]] = *value;
    }
    const Eigen::Vector3f point = Eigen::Vector3d(v[0], v[1], v[2]).cast<float>();
    vertices.points.push_back(point.allFinite() ? point : kNoReturn);
    const auto byte = [&](std::size_t slot) { return static_cast<std::uint8_t>(std::clamp(v[slot], 0.0, 255.0)); };
    if (has_colours) vertices.colours.push_back({byte(3), byte(4), byte(5)});
  }
  return vertices;
}

/// Cell by cell, row 0 first, which becomes the bottom row of the scan's picture.
Result<void> read_grid(const PlyElement& element, PlyNumbers& numbers, const Vertices& vertices, RangeScan& scan) {
  const auto columns = static_cast<std::size_t>(scan.points_m.width());
  for (std::size_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!property.count_type) {
        if (!numbers.skip(property)) return cut_short(element, i);
        continue;
      }
      const auto count = numbers.next_count(property);
      if (!count) return cut_short(element, i);
      if (*count == 0) continue;
      if (*count != 1)
        return broken("cell " + std::to_string(i) + " has " + std::to_string(*count) + " points; one was expected");
      const auto index = numbers.next(property.type);
      if (!index) return cut_short(element, i);
      if (!(*index >= 0) || *index >= static_cast<double>(vertices.points.size())) {
        return broken("cell " + std::to_string(i) + " names a point that is not there; there are " +
                      std::to_string(vertices.points.size()));
      }
      const auto vertex = static_cast<std::size_t>(*index);
      const int x = static_cast<int>(i % columns);
      const int y = scan.points_m.height() - 1 - static_cast<int>(i / columns);
      scan.points_m.at(x, y) = vertices.points[vertex];
      if (!scan.colours.empty()) scan.colours.at(x, y) = vertices.colours[vertex];
    }
  }
  return {};
}

Result<void> check_count(const PlyElement& element, const PlyHeader& header, std::size_t remaining,
                         const Limits& limits) {
  if (element.properties.empty()) return broken("the element " + element.name + " has no properties");
  if (element.count > limits.max_mesh_vertices || element.count > remaining / element.min_bytes(header.encoding)) {
    return broken("truncated: " + std::to_string(remaining) + " bytes cannot hold " + std::to_string(element.count) +
                  " of " + element.name);
  }
  return {};
}

}  // namespace

bool is_range_ply(std::string_view bytes) {
  const auto header = parse_ply_header(bytes);
  return header && element_named(*header, kGrid) != nullptr;
}

Result<RangeScan> parse_range_ply(std::string_view bytes, const Limits& limits) {
  const auto header = parse_ply_header(bytes);
  if (!header) return header.error();
  const PlyElement* grid = element_named(*header, kGrid);
  if (grid == nullptr) return broken("the PLY has no element 'range_grid'");
  const auto size = grid_size(*header, *grid, limits);
  if (!size) return size.error();
  PlyNumbers numbers(bytes.substr(header->body_offset), header->encoding);
  RangeScan scan;
  std::optional<Vertices> vertices;
  for (const PlyElement& element : header->elements) {
    if (auto ok = check_count(element, *header, numbers.remaining(), limits); !ok) return ok.error();
    if (element.name == "vertex" && !vertices) {
      auto read = read_vertices(element, numbers);
      if (!read) return read.error();
      vertices = *std::move(read);
    } else if (&element == grid) {
      if (!vertices) return broken("the grid stands before the vertices");
      scan.points_m = Image<Eigen::Vector3f>(size->columns, size->rows, kNoReturn);
      if (!vertices->colours.empty()) scan.colours = Image<Rgb8>(size->columns, size->rows);
      if (auto read = read_grid(element, numbers, *vertices, scan); !read) return read.error();
      break;  // whatever follows is not asked for
    } else {
      for (std::size_t i = 0; i < element.count; ++i) {
        for (const PlyProperty& property : element.properties) {
          if (!numbers.skip(property)) return cut_short(element, i);
        }
      }
    }
  }
  scan.sight = estimate_sight(scan.points_m);
  return scan;
}

}  // namespace scanknit
