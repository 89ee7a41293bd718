// PageJson: a look at some part of a report that may lack it, or have something else there.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace scanknit {

/// Refers to a value of the parsed report, or to null. Asked for what it is not, it answers 0, "", false or nothing.
class PageJson {
 public:
  /// `json` is a const nlohmann::ordered_json* and outlives it.
  explicit PageJson(const void* json) : json_(json) {}

  [[nodiscard]] bool is_object() const;
  [[nodiscard]] bool is_array() const;
  [[nodiscard]] bool is_structured() const { return is_object() || is_array(); }
  [[nodiscard]] bool is_number() const;  ///< and finite
  [[nodiscard]] bool is_string() const;
  [[nodiscard]] bool is_boolean() const;
  [[nodiscard]] bool is_null() const;

  [[nodiscard]] double as_number() const;
  [[nodiscard]] std::string as_text() const;
  [[nodiscard]] bool is_true() const;

  /// Of an array or an object.
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] bool empty() const { return size() == 0; }
  /// Of an array; null beyond its end.
  [[nodiscard]] PageJson operator[](std::size_t place) const;
  /// Of an object, in the file's order.
  [[nodiscard]] std::vector<std::pair<std::string, PageJson>> items() const;
  /// What is at `pointer` ("/mesh/triangles") below an object.
  [[nodiscard]] PageJson at(const std::string& pointer) const;

  /// As JSON on one line.
  [[nodiscard]] std::string dump() const;

 private:
  const void* json_;
};

}  // namespace scanknit
