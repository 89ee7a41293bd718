// scanknit.Error: our errors on their way to Python.
#pragma once

#include <pybind11/pybind11.h>

#include <stdexcept>
#include <utility>

#include "core/result.h"

namespace scanknit {

/// Thrown by our functions; Python gets a scanknit.Error.
struct Failure : std::runtime_error {
  explicit Failure(const Error& error) : std::runtime_error(error.text()), code(error.code) {}
  ErrorCode code;
};

/// The value, or a Failure.
template <typename T>
[[nodiscard]] T value_or_throw(Result<T> result) {
  if (!result) throw Failure(result.error());
  return std::move(result).value();
}
inline void succeed_or_throw(const Result<void>& result) {
  if (!result) throw Failure(result.error());
}

/// A scanknit.Error that is not raised.
[[nodiscard]] pybind11::object error_object(const Failure& failure);

void add_errors(pybind11::module_& module);

}  // namespace scanknit
