// BaseColours: converts the textures of a GLB to colours of vertices. Private to the GLB reader.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"
#include "export/glb/glb_accessor.h"

namespace tinygltf {
struct Image;
struct Material;
struct Primitive;
}  // namespace tinygltf

namespace scanknit {

/// The texels at the vertices of one primitive. Refers to the model and to its BaseColours.
class VertexTexels {
 public:
  /// Linear light: the texel times the material's factor.
  [[nodiscard]] Eigen::Vector3d colour(std::size_t vertex) const;

 private:
  friend class BaseColours;
  VertexTexels(const AccessorView& coordinates, const ColourImage& picture)
      : coordinates_(coordinates), picture_(&picture) {}

  AccessorView coordinates_;
  const ColourImage* picture_;
  int wrap_s_ = 0, wrap_t_ = 0;  ///< glTF 2.0, 5.26
  Eigen::Vector3d factor_ = Eigen::Vector3d::Ones();
};

/// Decodes each picture once. All pictures together may have as many pixels as the limit for one picture, or sixteen
/// for each byte of the file, up to 16384 x 16384 (805 MB), the largest that ScanKnit writes.
class BaseColours {
 public:
  BaseColours(const tinygltf::Model& model, const Limits& limits, std::size_t file_bytes);

  /// Nothing if the primitive has no base colour texture, or an unsupported one: then warnings() has the reason. Errors
  /// (kInput): a material, texture, picture or accessor is missing, or the number of coordinates differs from that of
  /// vertices.
  [[nodiscard]] Result<std::optional<VertexTexels>> of(const tinygltf::Primitive& primitive, std::size_t vertices);

  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  [[nodiscard]] Result<const ColourImage*> picture(int index);
  [[nodiscard]] Result<ColourImage> decoded(const tinygltf::Image& image);
  void warn(const std::string& why);

  const tinygltf::Model& model_;
  Limits limits_;  ///< limit of pixels that are left
  std::map<int, ColourImage> pictures_;
  bool has_failed_ = false;
  std::vector<std::string> warnings_;
};

}  // namespace scanknit
