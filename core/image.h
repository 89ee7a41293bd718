// Image<T>: a dense, row-major picture that owns its pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "core/check.h"

namespace scanknit {

/// 8-bit sRGB-encoded colour.
struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// std::allocator, except that a vector's new elements without a value are left uninitialised.
template <typename T>
struct UninitialisedAllocator : std::allocator<T> {
  template <typename U>
  struct rebind {
    using other = UninitialisedAllocator<U>;
  };
  template <typename U>
  void construct(U* element) {
    ::new (static_cast<void*>(element)) U;
  }
  template <typename U, typename... Values>
  void construct(U* element, Values&&... values) {
    ::new (static_cast<void*>(element)) U(std::forward<Values>(values)...);
  }
};

/// `width` x `height` pixels, row 0 at the top, no padding between rows. Empty when default-constructed.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T fill = T{})
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {
    SCANKNIT_CHECK(width >= 0 && height >= 0);
  }
  /// For images whose pixels are all written before they are read: saves filling them first.
  [[nodiscard]] static Image uninitialised(int width, int height) {
    Image image;
    image.width_ = width;
    image.height_ = height;
    image.pixels_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    return image;
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return pixels_.empty(); }
  [[nodiscard]] std::size_t size() const { return pixels_.size(); }
  [[nodiscard]] bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

  /// Unchecked in release: 0 <= x < width, 0 <= y < height.
  [[nodiscard]] T& at(int x, int y) { return pixels_[index(x, y)]; }
  [[nodiscard]] const T& at(int x, int y) const { return pixels_[index(x, y)]; }

  [[nodiscard]] std::span<T> row(int y) { return {pixels_.data() + index(0, y), static_cast<std::size_t>(width_)}; }
  [[nodiscard]] std::span<const T> row(int y) const {
    return {pixels_.data() + index(0, y), static_cast<std::size_t>(width_)};
  }
  [[nodiscard]] std::span<T> pixels() { return pixels_; }
  [[nodiscard]] std::span<const T> pixels() const { return pixels_; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  int width_ = 0;
  int height_ = 0;
  std::vector<T, UninitialisedAllocator<T>> pixels_;
};

/// Depth along the optical axis, metres. > 0 is a measurement; 0 is "no return". Never NaN, never negative.
using DepthImage = Image<float>;
using ColourImage = Image<Rgb8>;

}  // namespace scanknit
