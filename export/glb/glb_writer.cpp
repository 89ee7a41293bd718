#include <fmt/format.h>
#include <tiny_gltf.h>

#include <cmath>
#include <cstring>
#include <ostream>
#include <streambuf>

#include "core/version.h"
#include "export/glb/glb_parts.h"
#include "export/mesh/mesh_writers.h"
#include "export/texture/srgb.h"

namespace scanknit {
namespace {

constexpr std::uint64_t kContainerBytes = 28;         // file header 12, two chunk headers of 8
constexpr std::uint64_t kMaxJsonBytes = 4096;         // ours is about 1,300 bytes with one primitive
constexpr std::uint64_t kMaxJsonBytesOfAPart = 2048;  // and some 800 for each further one
constexpr std::uint16_t kOpaque = 65535;

/// `vertices`: of all parts.
std::uint64_t estimated_bytes(const Mesh& mesh, std::size_t vertices, std::size_t parts, const MeshTexture* texture) {
  const std::uint64_t per_vertex =
      12 + (mesh.normals.empty() ? 0u : 12u) + (mesh.colours.empty() ? 0u : 8u) + (texture == nullptr ? 0u : 8u);
  return kContainerBytes + kMaxJsonBytes + kMaxJsonBytesOfAPart * (parts - 1) + per_vertex * vertices +
         12ull * mesh.triangles.size() + (texture == nullptr ? 0u : texture->image.size());
}

template <typename T>
void append(std::vector<unsigned char>& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const auto* first = reinterpret_cast<const unsigned char*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof(T));
}

void append(std::vector<unsigned char>& bytes, const Eigen::Vector3f& v) {
  append(bytes, std::array<float, 3>{v.x(), v.y(), v.z()});
}

/// Builds the model's one buffer section by section: each becomes a buffer view and an accessor.
class SectionBuilder {
 public:
  SectionBuilder(tinygltf::Model& model, std::size_t bytes) : model_(model) {
    model_.buffers.emplace_back();
    bytes_().reserve(bytes);
  }

  /// Calls `fill(bytes)`, which appends `count` elements; returns the accessor's index.
  template <typename Fill>
  int add(std::size_t count, int type, int component_type, int target, Fill&& fill) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes_().size();
    fill(bytes_());
    view.byteLength = bytes_().size() - view.byteOffset;
    view.target = target;
    model_.bufferViews.push_back(std::move(view));

    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
    accessor.count = count;
    accessor.type = type;
    accessor.componentType = component_type;
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  /// Bytes that are no accessor's; returns the view's index.
  int add_bytes(const std::vector<unsigned char>& content) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes_().size();
    view.byteLength = content.size();
    bytes_().insert(bytes_().end(), content.begin(), content.end());
    model_.bufferViews.push_back(std::move(view));
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

 private:
  [[nodiscard]] std::vector<unsigned char>& bytes_() { return model_.buffers.front().data; }
  tinygltf::Model& model_;
};

/// What is written, and how.
struct Contents {
  const Mesh& mesh;
  const Placement& placement;
  const MeshTexture* texture;
};

int add_positions(const Contents& contents, const MeshPart& part, tinygltf::Model& model, SectionBuilder& sections) {
  const auto placed = [&](std::uint32_t v) { return contents.placement.position(contents.mesh.positions_m[v]); };
  Eigen::Vector3f low = placed(part.vertices.front());
  Eigen::Vector3f high = low;
  const int index = sections.add(part.vertices.size(), TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                 TINYGLTF_TARGET_ARRAY_BUFFER, [&](std::vector<unsigned char>& bytes) {
                                   for (const std::uint32_t vertex : part.vertices) {
                                     const Eigen::Vector3f p = placed(vertex);
                                     low = low.cwiseMin(p);
                                     high = high.cwiseMax(p);
                                     append(bytes, p);
                                   }
                                 });
  // glTF 2.0, 3.6.2.5: minimum and maximum must equal the stored floats, so they are those floats as doubles.
  tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
  accessor.minValues = {low.x(), low.y(), low.z()};
  accessor.maxValues = {high.x(), high.y(), high.z()};
  return index;
}

int add_normals(const Contents& contents, const MeshPart& part, SectionBuilder& sections) {
  return sections.add(part.vertices.size(), TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT,
                      TINYGLTF_TARGET_ARRAY_BUFFER, [&](std::vector<unsigned char>& bytes) {
                        for (const std::uint32_t v : part.vertices) {
                          const Eigen::Vector3d n = contents.placement.normal(contents.mesh.normals[v]).cast<double>();
                          const double length = n.norm();
                          append(bytes, length > 0 ? (n / length).cast<float>().eval() : Eigen::Vector3f(0, 1, 0));
                        }
                      });
}

/// Linear, 16-bit, four channels: glTF's COLOR_0 is linear; eight bits would band in the darks; three channels of 16
/// bits would break the 4-byte alignment.
int add_colours(const Contents& contents, const MeshPart& part, tinygltf::Model& model, SectionBuilder& sections) {
  std::array<std::uint16_t, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<std::uint16_t>(std::lround(65535 * linear_from_srgb(static_cast<std::uint8_t>(i))));
  }
  const int index =
      sections.add(part.vertices.size(), TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
                   TINYGLTF_TARGET_ARRAY_BUFFER, [&](std::vector<unsigned char>& bytes) {
                     for (const std::uint32_t vertex : part.vertices) {
                       const Rgb8 c = contents.mesh.colours[vertex];
                       append(bytes, std::array<std::uint16_t, 4>{linear[c.r], linear[c.g], linear[c.b], kOpaque});
                     }
                   });
  model.accessors[static_cast<std::size_t>(index)].normalized = true;
  return index;
}

int add_indices(const MeshPart& part, SectionBuilder& sections) {
  return sections.add(3 * part.triangles.size(), TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                      TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, [&](std::vector<unsigned char>& bytes) {
                        for (const Triangle& triangle : part.triangles) append(bytes, triangle);
                      });
}

int add_coordinates(const MeshTexture& texture, const MeshPart& part, SectionBuilder& sections) {
  return sections.add(part.vertices.size(), TINYGLTF_TYPE_VEC2, TINYGLTF_COMPONENT_TYPE_FLOAT,
                      TINYGLTF_TARGET_ARRAY_BUFFER, [&](std::vector<unsigned char>& bytes) {
                        for (const std::uint32_t vertex : part.vertices) {
                          const Eigen::Vector2f& uv = texture.coordinates[vertex];
                          append(bytes, std::array{uv.x(), uv.y()});
                        }
                      });
}

/// One primitive; all have the one material.
tinygltf::Primitive add_part(const Contents& contents, const MeshPart& part, tinygltf::Model& model,
                             SectionBuilder& sections) {
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = 0;
  primitive.attributes["POSITION"] = add_positions(contents, part, model, sections);
  if (!contents.mesh.normals.empty()) primitive.attributes["NORMAL"] = add_normals(contents, part, sections);
  if (!contents.mesh.colours.empty()) primitive.attributes["COLOR_0"] = add_colours(contents, part, model, sections);
  if (contents.texture != nullptr) {
    primitive.attributes["TEXCOORD_0"] = add_coordinates(*contents.texture, part, sections);
  }
  primitive.indices = add_indices(part, sections);
  return primitive;
}

/// The picture's file as it is, in a view of its own: the last, since nothing after it would be aligned.
void add_texture(const MeshTexture& texture, tinygltf::Model& model, SectionBuilder& sections) {
  tinygltf::Image image;
  image.bufferView = sections.add_bytes(texture.image);
  image.mimeType = texture.mime;
  model.images.push_back(std::move(image));
  tinygltf::Sampler sampler;
  sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
  sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR_MIPMAP_LINEAR;
  sampler.wrapS = sampler.wrapT = TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
  model.samplers.push_back(std::move(sampler));
  tinygltf::Texture made;
  made.source = 0;
  made.sampler = 0;
  model.textures.push_back(std::move(made));
  model.materials.front().pbrMetallicRoughness.baseColorTexture.index = 0;
}

/// glTF's default material is a metal, which is black without surroundings to mirror: ours always says otherwise.
void add_material(Material kind, tinygltf::Model& model) {
  tinygltf::Material material;
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 1;
  if (kind == Material::kUnlit) {
    material.extensions["KHR_materials_unlit"] = tinygltf::Value(tinygltf::Value::Object());
    model.extensionsUsed.emplace_back("KHR_materials_unlit");
  }
  model.materials.push_back(std::move(material));
}

tinygltf::Model build_model(const Contents& contents, GlbParts& parts, Material material) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = fmt::format("ScanKnit {}", kVersion);
  model.asset.extras = tinygltf::Value(tinygltf::Value::Object{{"units", tinygltf::Value(std::string("metre"))}});

  SectionBuilder sections(model, estimated_bytes(contents.mesh, parts.vertices(), parts.size(), contents.texture));
  model.meshes.emplace_back();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    model.meshes.back().primitives.push_back(add_part(contents, parts.part(i), model, sections));
  }
  add_material(material, model);
  if (contents.texture != nullptr) add_texture(*contents.texture, model, sections);

  model.nodes.emplace_back();
  model.nodes.back().mesh = 0;
  model.scenes.emplace_back();
  model.scenes.back().nodes = {0};
  model.defaultScene = 0;
  return model;
}

/// Hands what a library writes to a stream on to the file, so that it is in memory once less.
class FileBuffer : public std::streambuf {
 public:
  explicit FileBuffer(AtomicFile& file) : file_(file) {}

  [[nodiscard]] const Result<void>& written() const { return written_; }

  /// tinygltf 2.7.0 answers success whatever the stream did: the length its own header claims must be what there is.
  [[nodiscard]] bool is_whole_glb() const {
    if (head_.size() < kHeadBytes || !head_.starts_with("glTF")) return false;
    std::uint32_t length = 0;
    std::memcpy(&length, head_.data() + 8, sizeof(length));
    return length == bytes_;
  }

 private:
  static constexpr std::size_t kHeadBytes = 12;

  std::streamsize xsputn(const char* text, std::streamsize count) override {
    const std::string_view some(text, static_cast<std::size_t>(count));
    if (!written_) return 0;
    written_ = file_.write(some);
    if (!written_) return 0;
    head_ += some.substr(0, kHeadBytes - std::min(kHeadBytes, head_.size()));
    bytes_ += some.size();
    return count;
  }
  int_type overflow(int_type c) override {
    const char one = traits_type::to_char_type(c);
    return xsputn(&one, 1) == 1 ? c : traits_type::eof();
  }

  AtomicFile& file_;
  Result<void> written_;
  std::string head_;
  std::uint64_t bytes_ = 0;
};

}  // namespace

Result<void> write_glb(const Mesh& mesh, const Placement& placement, Material material, AtomicFile& file,
                       const MeshTexture* texture, const GlbLimits& limits) {
  const auto fits = [&](std::size_t vertices, std::size_t parts) {
    const std::uint64_t bytes = estimated_bytes(mesh, vertices, parts, texture);
    return bytes <= limits.max_bytes
               ? Result<void>()
               : Error{ErrorCode::kOutput, fmt::format("the GLB would have {} bytes, more than the limit of {}: take a "
                                                       "larger voxel size, or write PLY",
                                                       bytes, limits.max_bytes)};
  };
  if (auto whole = fits(mesh.positions_m.size(), 1); !whole) return whole;
  try {
    GlbParts parts(mesh, limits.max_vertices_of_a_primitive);
    if (auto in_parts = fits(parts.vertices(), parts.size()); !in_parts) return in_parts;
    FileBuffer buffer(file);
    std::ostream stream(&buffer);
    const tinygltf::Model model = build_model({mesh, placement, texture}, parts, material);
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, false, true)) {
      return Error{ErrorCode::kOutput, "tinygltf could not build the GLB"};
    }
    if (!buffer.written()) return buffer.written();
    if (!stream || !buffer.is_whole_glb()) return Error{ErrorCode::kOutput, "tinygltf built a GLB that is not whole"};
    return {};
  } catch (const std::exception& problem) {  // bad_alloc, or what tinygltf and its JSON library may throw
    return Error{ErrorCode::kOutput, std::string("the GLB could not be built: ") + problem.what()};
  }
}

}  // namespace scanknit
