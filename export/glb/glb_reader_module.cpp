// The module libscanknit_glb_reader.so.
#include <fmt/format.h>
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <span>

#include "core/version.h"
#include "export/glb/glb_accessor.h"
#include "export/glb/glb_container.h"
#include "export/glb/glb_decompression.h"
#include "export/glb/glb_reader.h"
#include "export/glb/glb_texture.h"
#include "export/mesh/mesh_builder.h"
#include "export/spill/stitch_borders.h"
#include "export/texture/srgb.h"

namespace scanknit {
namespace {

constexpr const char* kQuantization = "KHR_mesh_quantization";
constexpr int kMaxNodeDepth = 64;
// A mesh may be drawn by many nodes, so a small file can ask for a huge mesh. This many bytes of vertices and indices
// for each byte of the file are believed.
constexpr std::size_t kMaxExpansion = 16;
constexpr std::size_t kVertexBytes = sizeof(Eigen::Vector3f);

/// tinygltf must neither open files that a GLB names nor decode its pictures. Those that stand in the JSON itself are
/// kept as they are.
void forbid_side_effects(tinygltf::TinyGLTF& loader) {
  tinygltf::FsCallbacks closed{};
  closed.FileExists = [](const std::string&, void*) { return false; };
  closed.ExpandFilePath = [](const std::string& path, void*) { return path; };
  closed.ReadWholeFile = [](std::vector<unsigned char>*, std::string*, const std::string&, void*) { return false; };
  closed.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  loader.SetFsCallbacks(closed);
  loader.SetImageLoader(
      [](tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes, int count,
         void*) {
        if (image->bufferView < 0) image->image.assign(bytes, bytes + count);
        return true;
      },
      nullptr);
}

Result<tinygltf::Model> load(std::string_view bytes) {
  if (bytes.size() > std::numeric_limits<unsigned int>::max()) return input_error("a GLB file beyond 4 GiB");
  tinygltf::TinyGLTF loader;
  forbid_side_effects(loader);
  tinygltf::Model model;
  std::string error, warning;
  const bool is_loaded =
      loader.LoadBinaryFromMemory(&model, &error, &warning, reinterpret_cast<const unsigned char*>(bytes.data()),
                                  static_cast<unsigned int>(bytes.size()));
  if (!is_loaded) return input_error("the GLB cannot be understood: " + error.substr(0, error.find('\n')));
  for (const std::string& extension : model.extensionsRequired) {
    if (extension != "KHR_materials_unlit" && extension != kQuantization) {
      return input_error("the GLB needs the extension " + extension + ", which is not supported");
    }
  }
  return model;
}

/// A glTF node's own transform: a column-major matrix, or translation * rotation * scale.
Eigen::Affine3d local_transform(const tinygltf::Node& node) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  if (node.matrix.size() == 16) {
    transform.matrix() = Eigen::Map<const Eigen::Matrix4d>(node.matrix.data());
    return transform;
  }
  if (node.translation.size() == 3) transform.translate(Eigen::Map<const Eigen::Vector3d>(node.translation.data()));
  if (node.rotation.size() == 4) {
    const Eigen::Quaterniond q(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    transform.rotate(q);
  }
  if (node.scale.size() == 3) transform.scale(Eigen::Map<const Eigen::Vector3d>(node.scale.data()));
  return transform;
}

/// Gathers the triangles of every primitive of every node of the scene into one mesh.
class SceneReader {
 public:
  SceneReader(const tinygltf::Model& model, const Limits& limits, std::size_t file_bytes)
      : model_(model),
        limits_(limits),
        max_vertices_(kMaxExpansion * (file_bytes / kVertexBytes + 1)),
        max_corners_(kMaxExpansion * (file_bytes + 1)),
        base_colours_(model, limits, file_bytes),
        is_visited_(model.nodes.size(), false),
        may_be_quantised_(std::find(model.extensionsUsed.begin(), model.extensionsUsed.end(), kQuantization) !=
                          model.extensionsUsed.end()) {}

  [[nodiscard]] const std::vector<std::string>& warnings() const { return base_colours_.warnings(); }

  [[nodiscard]] bool has_texture_coordinates() const { return has_texture_coordinates_; }

  Result<Mesh> read() {
    for (const int root : roots()) {
      if (auto read = read_node(root, Eigen::Affine3d::Identity(), 0); !read) return read.error();
    }
    if (mesh_.positions_m.empty()) return input_error("the GLB holds no triangles");
    if (!all_have_normals_) mesh_.normals.clear();
    if (!all_have_colours_) mesh_.colours.clear();
    return std::move(mesh_);
  }

 private:
  [[nodiscard]] std::vector<int> roots() const {
    const std::size_t scene = model_.defaultScene >= 0 ? static_cast<std::size_t>(model_.defaultScene) : 0;
    if (scene < model_.scenes.size()) return model_.scenes[scene].nodes;
    std::vector<bool> has_parent(model_.nodes.size(), false);
    for (const tinygltf::Node& node : model_.nodes) {
      for (const int child : node.children) {
        if (child >= 0 && static_cast<std::size_t>(child) < has_parent.size()) {
          has_parent[static_cast<std::size_t>(child)] = true;
        }
      }
    }
    std::vector<int> parentless;
    for (std::size_t i = 0; i < has_parent.size(); ++i) {
      if (!has_parent[i]) parentless.push_back(static_cast<int>(i));
    }
    return parentless;
  }

  Result<void> read_node(int index, const Eigen::Affine3d& T_scene_parent, int depth) {
    if (index < 0 || static_cast<std::size_t>(index) >= model_.nodes.size()) {
      return input_error("the GLB names a node that is not there");
    }
    const auto i = static_cast<std::size_t>(index);
    if (is_visited_[i] || depth > kMaxNodeDepth) return input_error("the GLB's nodes are not a tree, or too deep");
    is_visited_[i] = true;
    const tinygltf::Node& node = model_.nodes[i];
    const Eigen::Affine3d T_scene_node = T_scene_parent * local_transform(node);
    if (node.mesh >= 0) {
      if (static_cast<std::size_t>(node.mesh) >= model_.meshes.size()) {
        return input_error("the GLB names a mesh that is not there");
      }
      if (auto read = read_primitives(model_.meshes[static_cast<std::size_t>(node.mesh)].primitives, T_scene_node);
          !read) {
        return read;
      }
    }
    for (const int child : node.children) {
      if (auto read = read_node(child, T_scene_node, depth + 1); !read) return read;
    }
    return {};
  }

  /// Those of one mesh: a large one of ours is in several, which are joined where they were cut.
  Result<void> read_primitives(const std::vector<tinygltf::Primitive>& primitives,
                               const Eigen::Affine3d& T_scene_node) {
    AppendedParts parts;
    parts.first_triangle = mesh_.triangles.size();
    const std::size_t first_vertex = mesh_.positions_m.size();
    const bool has_coordinates = std::any_of(primitives.begin(), primitives.end(), [](const auto& primitive) {
      return primitive.attributes.count("TEXCOORD_0") != 0;
    });
    has_texture_coordinates_ = has_texture_coordinates_ || has_coordinates;
    for (const tinygltf::Primitive& primitive : primitives) {
      parts.first_vertex.push_back(mesh_.positions_m.size());
      if (auto read = read_primitive(primitive, T_scene_node); !read) return read;
      if (primitives.size() == 1 || !has_coordinates) continue;
      parts.coordinates.resize(mesh_.positions_m.size() - first_vertex, Eigen::Vector2f::Zero());
      read_coordinates(primitive, std::span(parts.coordinates).subspan(parts.first_vertex.back() - first_vertex));
    }
    stitch_parts(mesh_, parts);
    return {};
  }

  /// Only to tell vertices apart: what cannot be read stays zero.
  void read_coordinates(const tinygltf::Primitive& primitive, std::span<Eigen::Vector2f> coordinates) const {
    const auto found = primitive.attributes.find("TEXCOORD_0");
    if (found == primitive.attributes.end()) return;
    const auto view = AccessorView::open(model_, found->second);
    if (!view || view->components() != 2 || view->count() != coordinates.size()) return;
    for (std::size_t i = 0; i < view->count(); ++i) {
      coordinates[i] = Eigen::Vector2d(view->meant(i, 0), view->meant(i, 1)).cast<float>();
    }
  }

  Result<void> read_primitive(const tinygltf::Primitive& primitive, const Eigen::Affine3d& T_scene_node) {
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES) return {};  // points and lines
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES)
      return input_error("glTF triangle strips and fans are not supported");
    const std::size_t base = mesh_.positions_m.size();
    if (auto read = read_positions(primitive, T_scene_node); !read) return read;
    const std::size_t count = mesh_.positions_m.size() - base;
    if (auto read = read_normals(primitive, T_scene_node, count); !read) return read;
    if (auto read = read_colours(primitive, count); !read) return read;
    return read_triangles(primitive, base, count, T_scene_node.linear().determinant() < 0);
  }

  Result<void> read_positions(const tinygltf::Primitive& primitive, const Eigen::Affine3d& T_scene_node) {
    const auto found = primitive.attributes.find("POSITION");
    if (found == primitive.attributes.end()) return input_error("a glTF primitive without positions");
    auto view = open_floats(found->second);
    if (!view) return view.error();
    const std::size_t have = mesh_.positions_m.size();
    if (view->count() > std::min(limits_.max_mesh_vertices, max_vertices_) - have) {
      return input_error("the GLB asks for more vertices than are believed");
    }
    for (std::size_t i = 0; i < view->count(); ++i) {
      mesh_.positions_m.push_back((T_scene_node * vector(*view, i)).cast<float>());
    }
    return {};
  }

  Result<void> read_normals(const tinygltf::Primitive& primitive, const Eigen::Affine3d& T_scene_node,
                            std::size_t count) {
    const auto found = primitive.attributes.find("NORMAL");
    all_have_normals_ = all_have_normals_ && found != primitive.attributes.end();
    if (!all_have_normals_) return {};
    auto view = open_floats(found->second);
    if (!view) return view.error();
    if (view->count() != count) return input_error("glTF normals that are not one a vertex");
    const Eigen::Matrix3d normal_matrix = T_scene_node.linear().inverse().transpose();
    for (std::size_t i = 0; i < count; ++i) {
      mesh_.normals.push_back((normal_matrix * vector(*view, i)).normalized().cast<float>());
    }
    return {};
  }

  Result<void> read_colours(const tinygltf::Primitive& primitive, std::size_t count) {
    const auto texels = base_colours_.of(primitive, count);
    if (!texels) return texels.error();
    const auto found = primitive.attributes.find("COLOR_0");
    const bool has_own = found != primitive.attributes.end();
    all_have_colours_ = all_have_colours_ && (has_own || *texels);
    if (!all_have_colours_) return {};
    std::optional<AccessorView> own;
    if (has_own) {
      auto view = AccessorView::open(model_, found->second);
      if (!view) return view.error();
      if (view->count() != count || view->components() < 3) {
        return input_error("glTF colours that are not one a vertex");
      }
      own = *view;
    }
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Vector3d linear = *texels ? (*texels)->colour(i) : Eigen::Vector3d::Ones();
      if (own)
        linear =
            linear.cwiseProduct(Eigen::Vector3d(own->normalised(i, 0), own->normalised(i, 1), own->normalised(i, 2)));
      mesh_.colours.push_back(
          {srgb_from_linear(linear.x()), srgb_from_linear(linear.y()), srgb_from_linear(linear.z())});
    }
    return {};
  }

  Result<void> read_triangles(const tinygltf::Primitive& primitive, std::size_t base, std::size_t count,
                              bool is_mirrored) {
    std::size_t corners = count;
    std::optional<AccessorView> indices;
    if (primitive.indices >= 0) {
      auto view = AccessorView::open(model_, primitive.indices);
      if (!view) return view.error();
      indices = *view;
      corners = view->count();
    }
    if (corners / 3 > limits_.max_mesh_triangles - std::min(mesh_.triangles.size(), limits_.max_mesh_triangles) ||
        corners > max_corners_ - std::min(3 * mesh_.triangles.size(), max_corners_)) {
      return input_error("the GLB asks for more triangles than are believed");
    }
    for (std::size_t i = 0; i + 2 < corners; i += 3) {
      Triangle triangle{};
      for (std::size_t c = 0; c < 3; ++c) {
        const double index = indices ? indices->value(i + c, 0) : static_cast<double>(i + c);
        if (!(index >= 0 && index < static_cast<double>(count))) {
          return input_error(fmt::format("a triangle names vertex {} of the {} there are", index, count));
        }
        triangle[c] = static_cast<std::uint32_t>(base + static_cast<std::size_t>(index));
      }
      if (is_mirrored) std::swap(triangle[1], triangle[2]);  // glTF 2.0, 3.7.4: a mirroring node flips the winding
      mesh_.triangles.push_back(triangle);
    }
    return {};
  }

  [[nodiscard]] Result<AccessorView> open_floats(int accessor) const {
    auto view = AccessorView::open(model_, accessor);
    const bool is_float = view && view->component_type() == TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (view && (view->components() != 3 || !(is_float || may_be_quantised_))) {
      return input_error("glTF positions or normals that are not three floats");
    }
    return view;
  }

  [[nodiscard]] static Eigen::Vector3d vector(const AccessorView& view, std::size_t i) {
    return {view.meant(i, 0), view.meant(i, 1), view.meant(i, 2)};
  }

  const tinygltf::Model& model_;
  const Limits& limits_;
  std::size_t max_vertices_;
  std::size_t max_corners_;
  BaseColours base_colours_;
  std::vector<bool> is_visited_;
  bool may_be_quantised_;
  Mesh mesh_;
  bool has_texture_coordinates_ = false;
  bool all_have_normals_ = true;
  bool all_have_colours_ = true;
};

Result<Mesh> mesh_of(std::string_view bytes, const Limits& limits, MeshNotes* notes) {
  if (auto ok = check_glb_container(bytes); !ok) return ok.error();
  try {
    const auto unpacked = without_meshopt(bytes, limits);
    if (!unpacked) return unpacked.error();
    if (*unpacked) bytes = **unpacked;
    const auto model = load(bytes);
    if (!model) return model.error();
    SceneReader reader(*model, limits, bytes.size());
    auto mesh = reader.read();
    if (notes != nullptr) {
      notes->warnings.insert(notes->warnings.end(), reader.warnings().begin(), reader.warnings().end());
      notes->has_texture_coordinates = reader.has_texture_coordinates();
    }
    return mesh;
  } catch (const std::exception& problem) {  // what tinygltf and its JSON library may throw
    return input_error(std::string("the GLB cannot be understood: ") + problem.what());
  }
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr GlbReader kOffers{mesh_of};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
