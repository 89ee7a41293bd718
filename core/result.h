// Result<T>: a value or an Error. It has the API of std::expected (C++23), which can replace it later.
#pragma once

#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/check.h"

namespace scanknit {

/// The kinds of errors; the program has one exit code for each (docs/cli.md).
enum class ErrorCode {
  kUsage,      ///< the command line asks for something that does not exist
  kConfig,     ///< a configuration value is unknown, malformed or out of range
  kInput,      ///< an input cannot be read, or has no usable data
  kDevice,     ///< a scanner is absent, busy, or needs permission
  kTooLittle,  ///< tracking was lost, or there is too little data
  kMesh,       ///< the mesh is empty or broken
  kOutput,     ///< an output cannot be written
  kBudget,     ///< a resource budget would be exceeded
  kInternal,   ///< a bug, or a fault of the installation: a module is missing
};

/// A message for the user: `where` names the file or object; `message` says what is wrong, what was expected, and what
/// to do next.
struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;
  std::string where = {};

  /// "where: message", or the message alone.
  [[nodiscard]] std::string text() const { return where.empty() ? message : where + ": " + message; }
};

template <typename T>
class [[nodiscard]] Result {
 public:
  using value_type = T;
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: implicit by design
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit by design

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }

  [[nodiscard]] T& value() & { return require(), std::get<0>(state_); }
  [[nodiscard]] const T& value() const& { return require(), std::get<0>(state_); }
  [[nodiscard]] T&& value() && { return require(), std::get<0>(std::move(state_)); }
  [[nodiscard]] T& operator*() & { return value(); }
  [[nodiscard]] const T& operator*() const& { return value(); }
  [[nodiscard]] T&& operator*() && { return std::move(*this).value(); }
  [[nodiscard]] T* operator->() { return &value(); }
  [[nodiscard]] const T* operator->() const { return &value(); }

  [[nodiscard]] const Error& error() const {
    SCANKNIT_CHECK(!has_value());
    return std::get<1>(state_);
  }

  /// Calls `next` with the value, or passes the error on.
  template <typename F>
  [[nodiscard]] auto and_then(F&& next) && -> std::invoke_result_t<F, T&&> {
    if (!has_value()) return error();
    return std::forward<F>(next)(std::move(*this).value());
  }

 private:
  void require() const { SCANKNIT_CHECK(has_value()); }
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  using value_type = void;
  Result() = default;
  Result(Error error) : error_(std::move(error)), ok_(false) {}  // NOLINT: implicit by design

  [[nodiscard]] bool has_value() const { return ok_; }
  explicit operator bool() const { return ok_; }
  [[nodiscard]] const Error& error() const {
    SCANKNIT_CHECK(!ok_);
    return error_;
  }

 private:
  Error error_;
  bool ok_ = true;
};

}  // namespace scanknit
