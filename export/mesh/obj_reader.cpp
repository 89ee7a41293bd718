#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/files/ascii_numbers.h"
#include "export/mesh/mesh_builder.h"
#include "export/mesh/mesh_readers.h"

namespace scanknit {
namespace {

/// A face corner "v", "v/vt", "v//vn" or "v/vt/vn"; texture coordinates are not used.
struct Corner {
  std::uint32_t vertex = 0;
  std::optional<std::uint32_t> normal;
};

/// OBJ indices count from 1; negative ones count back from the latest. An index may not point ahead.
std::optional<std::uint32_t> resolve(std::string_view word, std::size_t count) {
  const auto index = parse_integer(word);
  const auto n = static_cast<std::int64_t>(count);
  if (!index || *index == 0 || *index > n || *index < -n) return std::nullopt;
  return static_cast<std::uint32_t>(*index > 0 ? *index - 1 : n + *index);
}

class ObjReader {
 public:
  explicit ObjReader(const Limits& limits) : limits_(limits) {}

  Result<Mesh> read(std::string_view rest) {
    for (std::size_t line_number = 1; !rest.empty(); ++line_number) {
      if (auto read = read_line(take_line(rest)); !read) {
        return input_error(fmt::format("line {}: {}", line_number, read.error().message));
      }
    }
    if (mesh_.positions_m.empty()) return input_error("OBJ file without vertices");
    if (mesh_.colours.size() != mesh_.positions_m.size()) mesh_.colours.clear();
    mesh_.normals.resize(has_normals_ ? mesh_.positions_m.size() : 0, Eigen::Vector3f::Zero());
    return std::move(mesh_);
  }

 private:
  Result<void> read_line(std::string_view line) {
    const std::string_view keyword = take_word(line);
    if (keyword == "v") return read_vertex(line);
    if (keyword == "vn") return read_normal(line);
    if (keyword == "f") return read_face(line);
    return {};  // groups, materials, texture coordinates, comments
  }

  Result<void> read_vertex(std::string_view words) {
    std::array<float, 6> v{};
    std::size_t count = 0;
    for (std::string_view word = take_word(words); !word.empty() && count < v.size(); word = take_word(words)) {
      const auto value = parse_float(word);
      if (!value) return input_error("a vertex that is not made of numbers");
      v[count++] = *value;
    }
    if (count < 3) return input_error("a vertex of fewer than three numbers");
    if (mesh_.positions_m.size() == limits_.max_mesh_vertices) {
      return input_error(fmt::format("more vertices than the limit of {}", limits_.max_mesh_vertices));
    }
    mesh_.positions_m.emplace_back(v[0], v[1], v[2]);
    if (count == 6) mesh_.colours.push_back({byte(v[3]), byte(v[4]), byte(v[5])});
    return {};
  }

  Result<void> read_normal(std::string_view words) {
    Eigen::Vector3f normal;
    for (float& coordinate : normal) {
      const auto value = parse_float(take_word(words));
      if (!value) return input_error("a normal that is not three numbers");
      coordinate = *value;
    }
    listed_normals_.push_back(normal);
    return {};
  }

  [[nodiscard]] std::optional<Corner> parse_corner(std::string_view word) const {
    const std::size_t slash = word.find('/');
    const auto vertex = resolve(word.substr(0, slash), mesh_.positions_m.size());
    if (!vertex) return std::nullopt;
    const std::size_t second = slash == std::string_view::npos ? slash : word.find('/', slash + 1);
    if (second == std::string_view::npos) return Corner{*vertex, std::nullopt};
    const auto normal = resolve(word.substr(second + 1), listed_normals_.size());
    if (!normal) return std::nullopt;
    return Corner{*vertex, normal};
  }

  Result<void> read_face(std::string_view words) {
    corners_.clear();
    for (std::string_view word = take_word(words); !word.empty(); word = take_word(words)) {
      const auto corner = parse_corner(word);
      if (!corner) return input_error(fmt::format("a face corner '{}' that does not exist", word.substr(0, 40)));
      corners_.push_back(corner->vertex);
      if (corner->normal) set_normal(*corner);
    }
    return add_polygon(corners_, limits_, mesh_);
  }

  /// Our mesh has one normal a vertex: the first that a corner gives it.
  void set_normal(const Corner& corner) {
    has_normals_ = true;
    if (mesh_.normals.size() <= corner.vertex) mesh_.normals.resize(mesh_.positions_m.size(), Eigen::Vector3f::Zero());
    Eigen::Vector3f& normal = mesh_.normals[corner.vertex];
    if (normal.isZero(0)) normal = listed_normals_[*corner.normal];
  }

  static std::uint8_t byte(float channel) {
    return channel > 0 ? static_cast<std::uint8_t>(std::lround(255 * std::min(channel, 1.0f))) : std::uint8_t{0};
  }

  const Limits& limits_;
  Mesh mesh_;
  std::vector<Eigen::Vector3f> listed_normals_;
  std::vector<std::uint32_t> corners_;
  bool has_normals_ = false;
};

}  // namespace

Result<Mesh> read_obj(std::string_view bytes, const Limits& limits) {
  return ObjReader(limits).read(bytes);
}

}  // namespace scanknit
