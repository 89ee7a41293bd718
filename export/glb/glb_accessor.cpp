#include "export/glb/glb_accessor.h"

#include <tiny_gltf.h>

#include <algorithm>

#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "export/mesh/mesh_builder.h"

namespace scanknit {
namespace {

template <typename T>
double stored(std::span<const std::byte> bytes) {
  return static_cast<double>(ByteReader(bytes).little_endian<T>().value_or(T{}));
}

}  // namespace

Result<AccessorView> AccessorView::open(const tinygltf::Model& model, int accessor_index) {
  const tinygltf::Accessor* accessor = item(model.accessors, accessor_index);
  if (accessor == nullptr) return input_error("the GLB names an accessor that is not there");
  if (accessor->sparse.isSparse) return input_error("sparse glTF accessors are not supported");
  const tinygltf::BufferView* view = item(model.bufferViews, accessor->bufferView);
  if (view == nullptr) return input_error("a glTF accessor without data");
  const tinygltf::Buffer* buffer = item(model.buffers, view->buffer);
  if (buffer == nullptr) return input_error("the GLB names a buffer that is not there");

  const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor->type));
  const int component_bytes = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor->componentType));
  if (components <= 0 || component_bytes <= 0) return input_error("a glTF accessor of unknown type");

  AccessorView result;
  result.count_ = accessor->count;
  result.components_ = components;
  result.component_type_ = accessor->componentType;
  result.is_normalised_ = accessor->normalized;
  result.component_bytes_ = static_cast<std::size_t>(component_bytes);
  const std::size_t element_bytes = static_cast<std::size_t>(components) * result.component_bytes_;
  result.stride_ = view->byteStride == 0 ? element_bytes : view->byteStride;

  const Error outside = input_error("a glTF accessor reaches outside its buffer");
  const std::size_t buffer_bytes = buffer->data.size();
  if (view->byteOffset > buffer_bytes || view->byteLength > buffer_bytes - view->byteOffset) return outside;
  if (result.stride_ < element_bytes || accessor->byteOffset > view->byteLength) return outside;
  result.bytes_ = std::as_bytes(std::span(buffer->data))
                      .subspan(view->byteOffset + accessor->byteOffset, view->byteLength - accessor->byteOffset);
  if (result.count_ == 0) return result;
  const auto before_last = checked_mul(result.count_ - 1, result.stride_);
  if (!before_last || *before_last > result.bytes_.size() || element_bytes > result.bytes_.size() - *before_last) {
    return outside;
  }
  return result;
}

double AccessorView::value(std::size_t element, int component) const {
  const auto bytes =
      bytes_.subspan(element * stride_ + static_cast<std::size_t>(component) * component_bytes_, component_bytes_);
  switch (component_type_) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return stored<std::int8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return stored<std::uint8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_SHORT: return stored<std::int16_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return stored<std::uint16_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_INT: return stored<std::int32_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return stored<std::uint32_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return stored<float>(bytes);
    case TINYGLTF_COMPONENT_TYPE_DOUBLE: return stored<double>(bytes);
    default: return 0;
  }
}

double AccessorView::normalised(std::size_t element, int component) const {
  const double raw = value(element, component);
  if (component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return raw / 255;
  if (component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return raw / 65535;
  // glTF 2.0, 3.11: the lowest number of a signed type counts as the one above it.
  if (component_type_ == TINYGLTF_COMPONENT_TYPE_BYTE) return std::max(raw / 127, -1.0);
  if (component_type_ == TINYGLTF_COMPONENT_TYPE_SHORT) return std::max(raw / 32767, -1.0);
  return raw;
}

double AccessorView::meant(std::size_t element, int component) const {
  return is_normalised_ ? normalised(element, component) : value(element, component);
}

}  // namespace scanknit
