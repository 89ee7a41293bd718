#include "export/glb/glb_packing.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/version.h"
#include "export/glb/glb_container.h"
#include "export/glb/glb_parts.h"
#include "export/texture/srgb.h"

namespace scanknit {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

using Json = nlohmann::ordered_json;
using Bytes = std::vector<unsigned char>;

// glTF 2.0, 3.6.2.2 and 5.11.5.
constexpr int kByte = 5120, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071;  // 5.26
constexpr double kShortEnd = 65535, kByteEnd = 127;

/// One accessor with a buffer view of its own.
struct Section {
  std::string attribute;  ///< empty: the indices
  Json accessor;
  Bytes bytes;
  std::size_t stride = 0, count = 0;
};

template <typename T, std::size_t N>
void append(Bytes& bytes, const std::array<T, N>& values) {
  const std::size_t begin = bytes.size();
  bytes.resize(begin + sizeof(values));
  std::memcpy(bytes.data() + begin, values.data(), sizeof(values));
}

template <typename Fill>
Section section(std::string attribute, std::size_t stride, std::size_t count, Json accessor, Fill&& fill) {
  Section made{std::move(attribute), std::move(accessor), {}, stride, count};
  made.accessor["count"] = count;
  made.bytes.reserve(stride * count);
  for (std::size_t i = 0; i < count; ++i) fill(i, made.bytes);
  return made;
}

/// p = origin + side * stored / 65535: one scale for the three axes leaves normals as they are.
struct Grid {
  Eigen::Vector3f origin_m = Eigen::Vector3f::Zero();
  float side_m = 1;
};

class PackedGlb {
 public:
  PackedGlb(const Mesh& mesh, const Placement& placement, const ExportConfig& config, const MeshTexture* texture)
      : mesh_(mesh), placement_(placement), config_(config), texture_(texture) {
    if (config.quantize) find_grid();
  }

  [[nodiscard]] std::string bytes(GlbParts& parts) {
    Json views = Json::array();
    std::string binary;
    std::size_t plain_bytes = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      take_part(parts.part(i));
      std::vector<Section> sections = sections_of_part();
      for (const Section& section : sections) {
        views.push_back(config_.compress ? compressed_view(section, plain_bytes, binary) : plain_view(section, binary));
        plain_bytes += section.bytes.size();
      }
      add_primitive(sections);
    }
    if (texture_ != nullptr) {
      binary.resize((binary.size() + 3) / 4 * 4);
      views.push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", texture_->image.size()}});
      binary.append(texture_->image.begin(), texture_->image.end());
    }
    std::string json = document(std::move(views), binary.size(), plain_bytes).dump();
    return glb_container(std::move(json), std::move(binary));
  }

 private:
  /// The order in which they are written. Compressed: neighbours in the mesh become neighbours in the file.
  void take_part(MeshPart part) {
    const std::size_t n = part.vertices.size();
    order_ = std::move(part.vertices);
    indices_.clear();
    indices_.reserve(3 * part.triangles.size());
    for (const Triangle& t : part.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
    if (!config_.compress) return;
    std::vector<unsigned int> sorted(indices_.size()), place(n);
    meshopt_optimizeVertexCache(sorted.data(), indices_.data(), indices_.size(), n);
    auto used =
        static_cast<unsigned int>(meshopt_optimizeVertexFetchRemap(place.data(), sorted.data(), sorted.size(), n));
    std::vector<std::uint32_t> moved(n);
    for (std::size_t i = 0; i < n; ++i) {
      if (place[i] == ~0u) place[i] = used++;  // of no triangle: at the end
      moved[place[i]] = order_[i];
    }
    order_ = std::move(moved);
    for (std::size_t i = 0; i < sorted.size(); ++i) indices_[i] = place[sorted[i]];
  }

  [[nodiscard]] std::vector<Section> sections_of_part() const {
    std::vector<Section> sections;
    sections.push_back(positions());
    if (!mesh_.normals.empty()) sections.push_back(normals());
    if (!mesh_.colours.empty()) sections.push_back(colours());
    if (texture_ != nullptr) sections.push_back(coordinates());
    sections.push_back(section("", 4, indices_.size(), {{"componentType", kUnsignedInt}, {"type", "SCALAR"}},
                               [this](std::size_t i, Bytes& bytes) { append(bytes, std::array{indices_[i]}); }));
    return sections;
  }

  /// Accessors and buffer views have the same numbers.
  void add_primitive(std::vector<Section>& sections) {
    Json primitive = {{"attributes", Json::object()}, {"material", 0}, {"mode", 4}};
    for (Section& section : sections) {
      const std::size_t i = accessors_.size();
      section.accessor["bufferView"] = i;
      accessors_.push_back(std::move(section.accessor));
      (section.attribute.empty() ? primitive["indices"] : primitive["attributes"][section.attribute]) = i;
    }
    primitives_.push_back(std::move(primitive));
  }

  [[nodiscard]] Eigen::Vector3f position(std::size_t i) const {
    return placement_.position(mesh_.positions_m[order_[i]]);
  }

  /// Of the whole mesh, so that primitives agree on where their common vertices are.
  void find_grid() {
    Eigen::Vector3f low = placement_.position(mesh_.positions_m.front()), high = low;
    for (const Eigen::Vector3f& p : mesh_.positions_m) {
      low = low.cwiseMin(placement_.position(p));
      high = high.cwiseMax(placement_.position(p));
    }
    grid_.origin_m = low;
    const float side_m = (high - low).maxCoeff();
    if (side_m > 0) grid_.side_m = side_m;
  }

  [[nodiscard]] std::array<std::uint16_t, 4> on_grid(const Eigen::Vector3f& p) const {
    std::array<std::uint16_t, 4> stored{};  // the fourth fills the stride
    for (int axis = 0; axis < 3; ++axis) {
      const double share = (static_cast<double>(p[axis]) - grid_.origin_m[axis]) / grid_.side_m;
      stored[static_cast<std::size_t>(axis)] =
          static_cast<std::uint16_t>(std::lround(std::clamp(share, 0.0, 1.0) * kShortEnd));
    }
    return stored;
  }

  [[nodiscard]] Section positions() const {
    const std::size_t n = order_.size();
    Eigen::Vector3f lowest = position(0), highest = lowest;
    for (std::size_t i = 0; i < n; ++i) {
      lowest = lowest.cwiseMin(position(i));
      highest = highest.cwiseMax(position(i));
    }
    if (!config_.quantize) {
      // Minimum and maximum must equal the stored floats, so they are those floats as doubles.
      const Json accessor = {{"componentType", kFloat},
                             {"type", "VEC3"},
                             {"min", {double{lowest.x()}, double{lowest.y()}, double{lowest.z()}}},
                             {"max", {double{highest.x()}, double{highest.y()}, double{highest.z()}}}};
      return section("POSITION", 12, n, accessor, [this](std::size_t i, Bytes& bytes) {
        const Eigen::Vector3f p = position(i);
        append(bytes, std::array{p.x(), p.y(), p.z()});
      });
    }
    const auto low = on_grid(lowest), high = on_grid(highest);
    const Json accessor = {{"componentType", kUnsignedShort},
                           {"normalized", true},
                           {"type", "VEC3"},
                           {"min", {low[0], low[1], low[2]}},
                           {"max", {high[0], high[1], high[2]}}};
    return section("POSITION", 8, n, accessor,
                   [this](std::size_t i, Bytes& bytes) { append(bytes, on_grid(position(i))); });
  }

  /// Unit; +Y where the direction is unknown.
  [[nodiscard]] Eigen::Vector3d normal(std::size_t i) const {
    const Eigen::Vector3d n = placement_.normal(mesh_.normals[order_[i]]).cast<double>();
    return n.norm() > 0 ? n.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitY());
  }

  [[nodiscard]] Section normals() const {
    if (!config_.quantize) {
      return section("NORMAL", 12, order_.size(), {{"componentType", kFloat}, {"type", "VEC3"}},
                     [this](std::size_t i, Bytes& bytes) {
                       const Eigen::Vector3f n = normal(i).cast<float>();
                       append(bytes, std::array{n.x(), n.y(), n.z()});
                     });
    }
    return section("NORMAL", 4, order_.size(), {{"componentType", kByte}, {"normalized", true}, {"type", "VEC3"}},
                   [this](std::size_t i, Bytes& bytes) {
                     const Eigen::Vector3d n = normal(i) * kByteEnd;
                     const auto rounded = [](double v) { return static_cast<std::int8_t>(std::lround(v)); };
                     append(bytes, std::array{rounded(n.x()), rounded(n.y()), rounded(n.z()), std::int8_t{0}});
                   });
  }

  /// As in a plain GLB: linear, 16 bits, opaque.
  [[nodiscard]] Section colours() const {
    std::array<std::uint16_t, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i) {
      linear[i] = static_cast<std::uint16_t>(std::lround(kShortEnd * linear_from_srgb(static_cast<std::uint8_t>(i))));
    }
    return section("COLOR_0", 8, order_.size(),
                   {{"componentType", kUnsignedShort}, {"normalized", true}, {"type", "VEC4"}},
                   [&](std::size_t i, Bytes& bytes) {
                     const Rgb8 c = mesh_.colours[order_[i]];
                     append(bytes, std::array<std::uint16_t, 4>{linear[c.r], linear[c.g], linear[c.b], 65535});
                   });
  }

  /// Core glTF has them as floats, or as shares of 65535.
  [[nodiscard]] Section coordinates() const {
    if (!config_.quantize) {
      return section("TEXCOORD_0", 8, order_.size(), {{"componentType", kFloat}, {"type", "VEC2"}},
                     [this](std::size_t i, Bytes& bytes) {
                       const Eigen::Vector2f& uv = texture_->coordinates[order_[i]];
                       append(bytes, std::array{uv.x(), uv.y()});
                     });
    }
    return section("TEXCOORD_0", 4, order_.size(),
                   {{"componentType", kUnsignedShort}, {"normalized", true}, {"type", "VEC2"}},
                   [this](std::size_t i, Bytes& bytes) {
                     const auto rounded = [](float share) {
                       return static_cast<std::uint16_t>(std::lround(std::clamp(double{share}, 0.0, 1.0) * kShortEnd));
                     };
                     const Eigen::Vector2f& uv = texture_->coordinates[order_[i]];
                     append(bytes, std::array{rounded(uv.x()), rounded(uv.y())});
                   });
  }

  [[nodiscard]] static Json view_of(const Section& part, int buffer, std::size_t offset) {
    Json view = {{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", part.bytes.size()}};
    const bool is_index = part.attribute.empty();
    if (!is_index) view["byteStride"] = part.stride;  // forbidden for indices
    view["target"] = is_index ? kElementArrayBuffer : kArrayBuffer;
    return view;
  }

  [[nodiscard]] static Json plain_view(const Section& part, std::string& binary) {
    Json view = view_of(part, 0, binary.size());
    binary.append(part.bytes.begin(), part.bytes.end());
    return view;
  }

  /// `plain_offset`: in the buffer of those who cannot decompress, which is not in the file.
  [[nodiscard]] static Json compressed_view(const Section& part, std::size_t plain_offset, std::string& binary) {
    const Bytes packed = part.attribute.empty() ? packed_indices(part) : packed_vertices(part);
    Json view = view_of(part, 1, plain_offset);
    view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                     {"byteOffset", binary.size()},
                                                     {"byteLength", packed.size()},
                                                     {"byteStride", part.stride},
                                                     {"count", part.count},
                                                     {"mode", part.attribute.empty() ? "TRIANGLES" : "ATTRIBUTES"}};
    binary.append(packed.begin(), packed.end());
    binary.resize((binary.size() + 3) / 4 * 4);
    return view;
  }

  [[nodiscard]] static Bytes packed_indices(const Section& part) {
    std::vector<unsigned int> indices(part.count);
    std::memcpy(indices.data(), part.bytes.data(), part.bytes.size());
    const auto vertices = static_cast<std::size_t>(*std::max_element(indices.begin(), indices.end())) + 1;
    Bytes packed(meshopt_encodeIndexBufferBound(part.count, vertices));
    meshopt_encodeIndexVersion(1);  // the one that EXT_meshopt_compression names
    packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
    return packed;
  }

  [[nodiscard]] static Bytes packed_vertices(const Section& part) {
    Bytes packed(meshopt_encodeVertexBufferBound(part.count, part.stride));
    meshopt_encodeVertexVersion(0);  // likewise
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), part.bytes.data(), part.count, part.stride));
    return packed;
  }

  [[nodiscard]] Json document(Json views, std::size_t binary_bytes, std::size_t plain_bytes) {
    Json json;
    json["asset"] = {
        {"version", "2.0"}, {"generator", fmt::format("ScanKnit {}", kVersion)}, {"extras", {{"units", "metre"}}}};
    Json required = Json::array();
    if (config_.quantize) required.push_back("KHR_mesh_quantization");
    if (config_.compress) required.push_back("EXT_meshopt_compression");
    json["extensionsRequired"] = required;
    if (config_.material == Material::kUnlit) required.push_back("KHR_materials_unlit");
    json["extensionsUsed"] = required;
    json["scene"] = 0;
    json["scenes"] = Json::array({{{"nodes", {0}}}});
    Json node = {{"mesh", 0}};
    if (config_.quantize) {
      node["translation"] = {double{grid_.origin_m.x()}, double{grid_.origin_m.y()}, double{grid_.origin_m.z()}};
      node["scale"] = {double{grid_.side_m}, double{grid_.side_m}, double{grid_.side_m}};
    }
    json["nodes"] = Json::array({node});
    json["accessors"] = std::move(accessors_);
    json["meshes"] = Json::array({{{"primitives", std::move(primitives_)}}});
    Json material = {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}};
    if (config_.material == Material::kUnlit) material["extensions"]["KHR_materials_unlit"] = Json::object();
    if (texture_ != nullptr) {
      material["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
      json["images"] = Json::array({{{"bufferView", views.size() - 1}, {"mimeType", texture_->mime}}});
      json["samplers"] = Json::array({{{"magFilter", kLinear},
                                       {"minFilter", kLinearMipmapLinear},
                                       {"wrapS", kClampToEdge},
                                       {"wrapT", kClampToEdge}}});
      json["textures"] = Json::array({{{"source", 0}, {"sampler", 0}}});
    }
    json["materials"] = Json::array({material});
    json["bufferViews"] = std::move(views);
    json["buffers"] = Json::array({{{"byteLength", binary_bytes}}});
    if (config_.compress) {
      Json fallback = {{"byteLength", plain_bytes}};
      fallback["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
      json["buffers"].push_back(fallback);
    }
    return json;
  }

  const Mesh& mesh_;
  const Placement& placement_;
  const ExportConfig& config_;
  const MeshTexture* texture_;
  Grid grid_;
  Json accessors_ = Json::array(), primitives_ = Json::array();
  std::vector<unsigned int> indices_;  ///< of the part that is being written, in order_
  std::vector<std::uint32_t> order_;   ///< the mesh's vertex at each place of the part
};

}  // namespace

Result<void> write_packed_glb(const Mesh& mesh, const Placement& placement, const ExportConfig& config,
                              AtomicFile& file, const MeshTexture* texture, const GlbLimits& limits) {
  const auto fits = [&](std::size_t vertices) {
    // What viewers have in memory in the end counts, compressed or not.
    const std::uint64_t plain_bytes = (config.quantize ? 20ull : 32ull) * vertices + 12ull * mesh.triangles.size() +
                                      (texture == nullptr ? 0u : texture->image.size());
    return plain_bytes <= limits.max_bytes
               ? Result<void>()
               : Error{ErrorCode::kOutput, fmt::format("the GLB would unfold to {} bytes, more than the limit of {}: "
                                                       "take a larger voxel size, or write PLY",
                                                       plain_bytes, limits.max_bytes)};
  };
  if (auto whole = fits(mesh.positions_m.size()); !whole) return whole;
  try {
    GlbParts parts(mesh, limits.max_vertices_of_a_primitive);
    if (auto in_parts = fits(parts.vertices()); !in_parts) return in_parts;
    return file.write(PackedGlb(mesh, placement, config, texture).bytes(parts));
  } catch (const std::exception& problem) {  // bad_alloc
    return Error{ErrorCode::kOutput, std::string("the GLB could not be built: ") + problem.what()};
  }
}

}  // namespace scanknit
