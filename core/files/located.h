// located(): adds the place to an error.
#pragma once

#include <filesystem>

#include "core/result.h"

namespace scanknit {

/// The error with the place `place`, for example a file; if it has a place already, keeps that.
[[nodiscard]] inline Error located(Error error, const std::filesystem::path& place) {
  if (error.where.empty()) error.where = place.string();
  return error;
}

}  // namespace scanknit
