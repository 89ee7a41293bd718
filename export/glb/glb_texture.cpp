#include "export/glb/glb_texture.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/picture/decode_picture.h"
#include "export/mesh/mesh_builder.h"
#include "export/texture/srgb.h"

namespace scanknit {
namespace {

constexpr std::int64_t kMostPixels = 16384 * 16384;  // the end of export.texture_size
constexpr std::size_t kPixelsAByte = 16;  // PNG of few colours shrinks to that and further; photographs do not

/// The texel in a row of `side` at `share` of it.
int texel_at(double share, int wrap, int side) {
  if (!std::isfinite(share)) return 0;
  if (wrap == TINYGLTF_TEXTURE_WRAP_REPEAT) share -= std::floor(share);
  if (wrap == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) {
    share -= 2 * std::floor(share / 2);
    if (share > 1) share = 2 - share;
  }
  return static_cast<int>(std::clamp(std::floor(share * side), 0.0, side - 1.0));
}

const std::array<double, 256>& linear_of_byte() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> made{};
    for (std::size_t i = 0; i < made.size(); ++i) made[i] = linear_from_srgb(static_cast<std::uint8_t>(i));
    return made;
  }();
  return table;
}

/// The bytes of a picture's file; nothing when they are not in the GLB.
Result<std::span<const std::byte>> file_of(const tinygltf::Model& model, const tinygltf::Image& image) {
  if (image.bufferView < 0) return std::as_bytes(std::span(image.image));  // what stood in the JSON itself
  const tinygltf::BufferView* view = item(model.bufferViews, image.bufferView);
  const tinygltf::Buffer* buffer = view == nullptr ? nullptr : item(model.buffers, view->buffer);
  if (buffer == nullptr) return input_error("the GLB names a picture that is not there");
  const std::size_t bytes = buffer->data.size();
  if (view->byteOffset > bytes || view->byteLength > bytes - view->byteOffset) {
    return input_error("a picture of the GLB reaches outside its buffer");
  }
  return std::as_bytes(std::span(buffer->data)).subspan(view->byteOffset, view->byteLength);
}

}  // namespace

Eigen::Vector3d VertexTexels::colour(std::size_t vertex) const {
  const int x = texel_at(coordinates_.meant(vertex, 0), wrap_s_, picture_->width());
  const int y = texel_at(coordinates_.meant(vertex, 1), wrap_t_, picture_->height());
  const Rgb8 texel = picture_->at(x, y);
  const auto& linear = linear_of_byte();
  return factor_.cwiseProduct(Eigen::Vector3d(linear[texel.r], linear[texel.g], linear[texel.b]));
}

BaseColours::BaseColours(const tinygltf::Model& model, const Limits& limits, std::size_t file_bytes)
    : model_(model), limits_(limits) {
  const auto believed = static_cast<std::int64_t>(std::min<std::size_t>(file_bytes, kMostPixels) * kPixelsAByte);
  limits_.max_image_pixels = std::max(limits.max_image_pixels, std::min(believed, kMostPixels));
}

Result<std::optional<VertexTexels>> BaseColours::of(const tinygltf::Primitive& primitive, std::size_t vertices) {
  const std::optional<VertexTexels> none;
  if (primitive.material < 0) return none;
  const tinygltf::Material* material = item(model_.materials, primitive.material);
  if (material == nullptr) return input_error("the GLB names a material that is not there");
  const tinygltf::TextureInfo& wanted = material->pbrMetallicRoughness.baseColorTexture;
  if (wanted.index < 0) return none;
  const tinygltf::Texture* texture = item(model_.textures, wanted.index);
  if (texture == nullptr) return input_error("the GLB names a texture that is not there");

  const auto found = primitive.attributes.find(fmt::format("TEXCOORD_{}", wanted.texCoord));
  if (found == primitive.attributes.end()) return none;  // glTF 2.0, 3.9.2: there is nothing to show
  const auto coordinates = AccessorView::open(model_, found->second);
  if (!coordinates) return coordinates.error();
  if (coordinates->count() != vertices || coordinates->components() != 2) {
    return input_error("glTF texture coordinates that are not two a vertex");
  }
  if (wanted.extensions.count("KHR_texture_transform") != 0) {
    warn("its coordinates are transformed by KHR_texture_transform, which is not supported");
    return none;
  }
  if (texture->source < 0) {
    warn("its picture is of a kind that only an extension knows; PNG and JPEG are read");
    return none;
  }
  const auto shown = picture(texture->source);
  if (!shown) return shown.error();
  if (*shown == nullptr) return none;

  VertexTexels texels(*coordinates, **shown);
  const tinygltf::Sampler* sampler = item(model_.samplers, texture->sampler);
  if (texture->sampler >= 0 && sampler == nullptr) return input_error("the GLB names a sampler that is not there");
  texels.wrap_s_ = sampler == nullptr ? TINYGLTF_TEXTURE_WRAP_REPEAT : sampler->wrapS;
  texels.wrap_t_ = sampler == nullptr ? TINYGLTF_TEXTURE_WRAP_REPEAT : sampler->wrapT;
  const std::vector<double>& factor = material->pbrMetallicRoughness.baseColorFactor;
  if (factor.size() >= 3) texels.factor_ = {factor[0], factor[1], factor[2]};
  return std::optional(texels);
}

/// Null for one that cannot be shown, and for all after it: a mesh has colours everywhere or nowhere.
Result<const ColourImage*> BaseColours::picture(int index) {
  const tinygltf::Image* image = item(model_.images, index);
  if (image == nullptr) return input_error("the GLB names a picture that is not there");
  if (const auto known = pictures_.find(index); known != pictures_.end()) return &known->second;
  if (has_failed_) return nullptr;
  auto made = decoded(*image);
  has_failed_ = !made;
  if (has_failed_) {
    warn(made.error().message);
    return nullptr;
  }
  limits_.max_image_pixels -= static_cast<std::int64_t>(made->size());
  return &pictures_.emplace(index, *std::move(made)).first->second;
}

Result<ColourImage> BaseColours::decoded(const tinygltf::Image& image) {
  const auto file = file_of(model_, image);
  if (!file) return file.error();
  if (file->empty()) return input_error("its picture is not in the file");
  auto picture = decode_picture(*file, limits_);
  if (!picture) return input_error("its picture cannot be shown: " + picture.error().message);
  return picture;
}

void BaseColours::warn(const std::string& why) {
  const std::string warning = "the texture is left out: " + why;
  if (std::find(warnings_.begin(), warnings_.end(), warning) == warnings_.end()) warnings_.push_back(warning);
}

}  // namespace scanknit
