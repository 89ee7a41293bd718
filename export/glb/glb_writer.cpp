#include "export/glb/glb_writer.h"

#include <fmt/format.h>

#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/version.h"
#include "export/glb/glb_arrays.h"
#include "export/glb/glb_compression.h"
#include "export/glb/glb_container.h"
#include "export/glb/glb_parts.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;                 // glTF 2.0, 5.11.5
constexpr int kTriangles = 4;                                                    // 5.24.4
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071;  // 5.26

/// Of the file before compression, a little more than it will have. `vertices`: of all parts.
std::uint64_t expected_bytes(const GlbContents& contents, bool is_quantized, std::size_t vertices, std::size_t parts) {
  constexpr std::uint64_t kContainerBytes = 28;      // file header 12, two chunk headers of 8
  constexpr std::uint64_t kJsonBytes = 4096;         // some 2,500 at most with one primitive
  constexpr std::uint64_t kJsonBytesOfAPart = 2048;  // and 1,600 for each further one
  return kContainerBytes + kJsonBytes + kJsonBytesOfAPart * (parts - 1) +
         bytes_of_a_vertex(contents, is_quantized) * vertices + sizeof(Triangle) * contents.mesh.triangles.size() +
         (contents.texture == nullptr ? 0u : contents.texture->image.size());
}

/// Gathers the JSON document of a GLB, and writes it with the binary data that it describes. These are in memory only
/// if they are compressed, since nothing else tells their size before.
class GlbBuilder {
 public:
  GlbBuilder(const GlbContents& contents, const ExportConfig& config) : contents_(contents), config_(config) {
    if (config.quantize) grid_ = quantization_grid(contents.mesh, contents.placement);
  }

  /// Accessors and buffer views have the same numbers.
  void add_primitive(GlbPart part) {
    MeshPart ordered;
    if (config_.compress) {
      ordered = in_order_of_use(part);
      part = {ordered.vertices, ordered.triangles};
    }
    Json primitive = {{"attributes", Json::object()}, {"material", 0}, {"mode", kTriangles}};
    const GlbBytes bytes = config_.compress ? GlbBytes::kMade : GlbBytes::kLeftOut;
    for_each_array(contents_, part, grid(), bytes, [&](const GlbArray& array) {
      const std::size_t number = accessors_.size();
      accessors_.push_back(accessor(array, number));
      views_.push_back(config_.compress ? compressed_view(array) : view(array));
      (array.is_indices() ? primitive["indices"] : primitive["attributes"][std::string(array.attribute)]) = number;
    });
    primitives_.push_back(std::move(primitive));
  }

  /// The last of the binary data, since nothing after it would be aligned.
  void add_picture(const std::vector<std::uint8_t>& image) {
    views_.push_back({{"buffer", 0}, {"byteOffset", binary_bytes_}, {"byteLength", image.size()}});
    binary_bytes_ += image.size();
  }

  /// `parts`: those that were added.
  [[nodiscard]] Result<void> write(GlbParts& parts, AtomicFile& file) {
    const Json whole = document();
    const GlbShell shell = glb_shell(is_plain() ? plain_text(whole) : whole.dump(), binary_bytes_);
    if (auto written = file.write(shell.before); !written) return written;
    if (auto written = config_.compress ? file.write(compressed_) : write_arrays(parts, file); !written) return written;
    if (contents_.texture != nullptr) {
      if (auto written = file.write(characters(contents_.texture->image)); !written) return written;
    }
    return file.write(shell.after);
  }

 private:
  [[nodiscard]] static std::string_view characters(std::span<const unsigned char> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  [[nodiscard]] const QuantizationGrid* grid() const { return grid_ ? &*grid_ : nullptr; }

  [[nodiscard]] Result<void> write_arrays(GlbParts& parts, AtomicFile& file) const {
    Result<void> written;
    for (std::size_t i = 0; i < parts.size() && written; ++i) {
      for_each_array(contents_, parts.part(i), grid(), GlbBytes::kMade, [&](const GlbArray& array) {
        if (written) written = file.write(characters(array.bytes));
      });
    }
    return written;
  }

  [[nodiscard]] bool is_plain() const { return !config_.quantize && !config_.compress; }

  [[nodiscard]] static Json accessor(const GlbArray& array, std::size_t view) {
    Json json = {{"componentType", array.component_type}};
    if (array.is_normalised) json["normalized"] = true;
    json["type"] = array.type;
    if (!array.lowest.empty()) {
      json["min"] = bound(array.lowest, array.is_normalised);
      json["max"] = bound(array.highest, array.is_normalised);
    }
    json["count"] = array.count;
    json["bufferView"] = view;
    return json;
  }

  [[nodiscard]] static Json bound(const std::vector<double>& values, bool are_integers) {
    Json json = Json::array();
    for (const double value : values) json.push_back(are_integers ? Json(static_cast<int>(value)) : Json(value));
    return json;
  }

  [[nodiscard]] static Json view_at(const GlbArray& array, int buffer, std::size_t offset) {
    Json json = {{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", array.byte_length()}};
    if (!array.is_indices()) json["byteStride"] = array.stride;  // forbidden for indices
    json["target"] = array.is_indices() ? kElementArrayBuffer : kArrayBuffer;
    return json;
  }

  [[nodiscard]] Json view(const GlbArray& array) {
    Json json = view_at(array, 0, binary_bytes_);
    binary_bytes_ += array.byte_length();  // a multiple of four
    return json;
  }

  /// It lies in a second buffer, which is not in the file, and says where its compressed bytes are in the first.
  [[nodiscard]] Json compressed_view(const GlbArray& array) {
    const std::vector<unsigned char> packed = compressed(array);
    Json json = view_at(array, 1, uncompressed_bytes_);
    json["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                     {"byteOffset", compressed_.size()},
                                                     {"byteLength", packed.size()},
                                                     {"byteStride", array.stride},
                                                     {"count", array.count},
                                                     {"mode", array.is_indices() ? "TRIANGLES" : "ATTRIBUTES"}};
    compressed_.append(packed.begin(), packed.end());
    compressed_.resize((compressed_.size() + 3) / 4 * 4);
    binary_bytes_ = compressed_.size();
    uncompressed_bytes_ += array.byte_length();
    return json;
  }

  [[nodiscard]] Json document() {
    Json json;
    json["asset"] = {
        {"version", "2.0"}, {"generator", fmt::format("ScanKnit {}", kVersion)}, {"extras", {{"units", "metre"}}}};
    add_extensions(json);
    json["scene"] = 0;
    json["scenes"] = Json::array({{{"nodes", {0}}}});
    json["nodes"] = Json::array({node()});
    json["accessors"] = std::move(accessors_);
    json["meshes"] = Json::array({{{"primitives", std::move(primitives_)}}});
    if (contents_.texture != nullptr) add_texture(json);
    json["materials"] = Json::array({material()});
    json["bufferViews"] = std::move(views_);
    json["buffers"] = Json::array({{{"byteLength", binary_bytes_}}});
    if (config_.compress) {
      Json uncompressed = {{"byteLength", uncompressed_bytes_}};
      uncompressed["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
      json["buffers"].push_back(uncompressed);
    }
    return json;
  }

  void add_extensions(Json& json) const {
    Json extensions = Json::array();
    if (config_.quantize) extensions.push_back("KHR_mesh_quantization");
    if (config_.compress) extensions.push_back("EXT_meshopt_compression");
    if (!extensions.empty()) json["extensionsRequired"] = extensions;
    if (config_.material == Material::kUnlit) extensions.push_back("KHR_materials_unlit");
    if (!extensions.empty()) json["extensionsUsed"] = extensions;
  }

  [[nodiscard]] Json node() const {
    Json json = {{"mesh", 0}};
    if (grid_) {
      const double side_m = grid_->side_m;
      const Eigen::Vector3d origin_m = grid_->origin_m.cast<double>();
      json["translation"] = {origin_m.x(), origin_m.y(), origin_m.z()};
      json["scale"] = {side_m, side_m, side_m};
    }
    return json;
  }

  /// The picture is in the last view.
  void add_texture(Json& json) const {
    json["images"] = Json::array({{{"bufferView", views_.size() - 1}, {"mimeType", contents_.texture->mime}}});
    json["samplers"] = Json::array({{{"magFilter", kLinear},
                                     {"minFilter", kLinearMipmapLinear},
                                     {"wrapS", kClampToEdge},
                                     {"wrapT", kClampToEdge}}});
    json["textures"] = Json::array({{{"source", 0}, {"sampler", 0}}});
  }

  /// glTF's default material is a metal, which is black without surroundings to mirror: ours always says otherwise.
  [[nodiscard]] Json material() const {
    Json json = {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}};
    if (contents_.texture != nullptr) json["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
    if (config_.material == Material::kUnlit) json["extensions"]["KHR_materials_unlit"] = Json::object();
    return json;
  }

  /// A file without the two extensions has its keys in the order of the alphabet and leaves out what glTF assumes. It
  /// says the same; plain files have always been written so, and the same mesh is to give the same bytes.
  [[nodiscard]] static std::string plain_text(const Json& document) {
    nlohmann::json plain = document;  // its objects sort their keys
    for (nlohmann::json& view : plain["bufferViews"]) {
      view.erase("byteStride");
      if (view["byteOffset"] == 0) view.erase("byteOffset");
    }
    nlohmann::json& material = plain["materials"][0]["pbrMetallicRoughness"];
    material.erase("roughnessFactor");
    material["metallicFactor"] = 0.0;
    return plain.dump();
  }

  const GlbContents& contents_;
  const ExportConfig& config_;
  std::optional<QuantizationGrid> grid_;
  Json accessors_ = Json::array(), views_ = Json::array(), primitives_ = Json::array();
  std::string compressed_;
  std::size_t binary_bytes_ = 0, uncompressed_bytes_ = 0;
};

}  // namespace

Result<void> write_glb(const GlbContents& contents, const ExportConfig& config, AtomicFile& file,
                       std::uint64_t max_bytes) {
  // What viewers have in memory in the end counts, compressed or not.
  const auto fits = [&](std::uint64_t bytes) {
    return bytes <= max_bytes
               ? Result<void>()
               : Error{ErrorCode::kOutput, fmt::format("the GLB would {} {} bytes, more than the limit of {}: take a "
                                                       "larger voxel size, or write PLY",
                                                       config.compress ? "unfold to" : "have", bytes, max_bytes)};
  };
  if (auto whole = fits(expected_bytes(contents, config.quantize, contents.mesh.positions_m.size(), 1)); !whole) {
    return whole;
  }
  try {
    GlbParts parts(contents.mesh, config.max_vertices_of_a_primitive);
    const std::uint64_t bytes = expected_bytes(contents, config.quantize, parts.vertices(), parts.size());
    if (auto in_parts = fits(bytes); !in_parts) return in_parts;
    GlbBuilder builder(contents, config);
    for (std::size_t i = 0; i < parts.size(); ++i) builder.add_primitive(parts.part(i));
    if (contents.texture != nullptr) builder.add_picture(contents.texture->image);
    return builder.write(parts, file);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while the GLB was built; larger voxels, or a file .ply, need less"};
  } catch (const std::exception& problem) {
    return Error{ErrorCode::kOutput, std::string("the GLB could not be built: ") + problem.what()};
  }
}

}  // namespace scanknit
