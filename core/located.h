// located: an error says where it happened.
#pragma once

#include <filesystem>

#include "core/result.h"

namespace scanknit {

/// The error, which happened at `place`, a file for instance. A place that it names already stays.
[[nodiscard]] inline Error located(Error error, const std::filesystem::path& place) {
  if (error.where.empty()) error.where = place.string();
  return error;
}

}  // namespace scanknit
