// Reading a whole file into memory, within a limit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// The bytes of a regular file of at most `max_bytes`. The file may be empty. Errors (kInput, `where` = the path): it
/// does not exist, is a folder or a device, has no permission or is larger than the limit; a read failed.
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uintmax_t max_bytes);

/// The same as text.
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& path, std::uintmax_t max_bytes);

}  // namespace scanknit
