// Rare: what few frames of a recording have of their own. Private to the room.
#pragma once

#include <memory>
#include <optional>
#include <utility>

namespace scanknit {

/// Like std::optional, but as small as two pointers where there is nothing, as in most recordings: a long one keeps one
/// for each of its frames. Copies share the value, which does not change.
template <typename T>
class Rare {
 public:
  Rare() = default;
  // From a value, or an optional one, by itself, as std::optional.
  Rare(T value) : value_(std::make_shared<const T>(std::move(value))) {}  // NOLINT(google-explicit-constructor)
  Rare(std::optional<T> value) {                                          // NOLINT(google-explicit-constructor)
    if (value) value_ = std::make_shared<const T>(*std::move(value));
  }

  [[nodiscard]] bool has_value() const { return value_ != nullptr; }
  explicit operator bool() const { return has_value(); }
  const T& operator*() const { return *value_; }
  const T* operator->() const { return value_.get(); }
  [[nodiscard]] T value_or(T otherwise) const { return value_ ? *value_ : std::move(otherwise); }
  [[nodiscard]] std::optional<T> copy() const { return value_ ? std::optional<T>(*value_) : std::nullopt; }
  void reset() { value_ = nullptr; }

 private:
  std::shared_ptr<const T> value_;
};

}  // namespace scanknit
