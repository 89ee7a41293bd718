// Keywords: the keyword arguments of one call. One that is absent, or None, leaves our own type's default as it is.
#pragma once

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <string>
#include <utility>

namespace scanknit {

class Keywords {
 public:
  explicit Keywords(pybind11::kwargs given) : given_(std::move(given)) {}

  /// Sets `place` to the argument of that name. A TypeError for what a `Value` cannot be.
  template <typename Value>
  void read(const char* name, Value& place) {
    const pybind11::object given = take(name);
    if (given.is_none()) return;
    try {
      place = given.cast<Value>();
    } catch (const pybind11::builtin_exception&) {
      throw pybind11::type_error(fmt::format("{}: cannot be {}", name, pybind11::repr(given).cast<std::string>()));
    }
  }

  /// A number from `least` to `most`, else a ValueError; nothing if it is absent.
  template <typename Number>
  [[nodiscard]] std::optional<Number> number(const char* name, double least, double most) {
    std::optional<Number> number;
    read(name, number);
    if (!number) return number;
    const auto value = static_cast<double>(*number);
    if (value >= least && value <= most) return number;  // NaN is neither
    throw pybind11::value_error(fmt::format("{}: expected {} to {}, got {}", name, least, most, value));
  }

  /// A TypeError if there is an argument that was not read.
  void refuse_others() const;

 private:
  /// None if there is no argument of that name.
  [[nodiscard]] pybind11::object take(const char* name);

  pybind11::dict given_;  ///< those that were not read yet
};

}  // namespace scanknit
