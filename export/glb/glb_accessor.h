// AccessorView: checked reading of one glTF accessor. Private to the GLB reader.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"

namespace tinygltf {
class Model;
}

namespace scanknit {

/// The element with an index from the file; null if it does not exist.
template <typename T>
[[nodiscard]] const T* item(const std::vector<T>& items, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < items.size() ? &items[static_cast<std::size_t>(index)]
                                                                      : nullptr;
}

/// The elements of an accessor, all of whose bytes are checked to be inside its buffer. Refers to the model's memory.
class AccessorView {
 public:
  /// Errors (kInput): any index out of range, sparse or dataless accessors, bytes outside of the buffer.
  [[nodiscard]] static Result<AccessorView> open(const tinygltf::Model& model, int accessor);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] int components() const { return components_; }
  [[nodiscard]] int component_type() const { return component_type_; }

  /// The component as stored; `element` < count(), `component` < components().
  [[nodiscard]] double value(std::size_t element, int component) const;
  /// The component as a colour: integers scaled to 0..1 or -1..1, floats unchanged.
  [[nodiscard]] double normalised(std::size_t element, int component) const;
  /// normalised() if the accessor is normalised, else value().
  [[nodiscard]] double meant(std::size_t element, int component) const;

 private:
  std::span<const std::byte> bytes_;
  std::size_t count_ = 0;
  std::size_t stride_ = 0;
  int components_ = 0;
  int component_type_ = 0;
  bool is_normalised_ = false;
  std::size_t component_bytes_ = 0;
};

}  // namespace scanknit
