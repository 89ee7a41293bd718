// Checks the name of a recording before it is written.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/result.h"

namespace scanknit {

/// Recordings are never overwritten. Errors (kOutput): something of this name exists already; the message ends with
/// `remedy`.
[[nodiscard]] Result<void> check_is_new_recording(const std::filesystem::path& path,
                                                  std::string_view remedy = "give another -o");

}  // namespace scanknit
