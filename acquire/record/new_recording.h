// The name of a file that is about to be written.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/result.h"

namespace scanknit {

/// Recordings are not overwritten. Errors (kOutput): something of this name is there already; `remedy` is what the
/// message advises.
[[nodiscard]] Result<void> check_is_new_recording(const std::filesystem::path& path,
                                                  std::string_view remedy = "give another -o");

}  // namespace scanknit
