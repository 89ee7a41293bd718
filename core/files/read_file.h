// Reading a whole file into memory, within a limit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// The bytes of a regular file of at most `max_bytes`. Errors (kInput, `where` = the path): not there, a folder or a
/// device, no permission, empty is allowed, larger than the limit, a failed read.
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uintmax_t max_bytes);

/// The same as text.
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path, std::uintmax_t max_bytes);

}  // namespace scanknit
