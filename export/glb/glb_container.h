// The container of a GLB file: writes it, and checks it before a library parses it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "core/result.h"

namespace scanknit {

/// Errors (kInput): no GLB 2 header, a length in the header that is not that of the file, chunks that do not fit, a
/// JSON chunk nested deeper than `max_depth` (recursive parsers would run out of stack).
[[nodiscard]] Result<void> check_glb_container(std::string_view bytes, int max_depth = 64);

/// The bytes of a GLB file before and after its binary data (glTF 2.0, 4.4).
struct GlbShell {
  std::string before;  ///< the file's header, the JSON chunk, and the header of the binary chunk
  std::string after;   ///< zeros up to a multiple of four
};

/// The shell for `binary_bytes` of data. Data and JSON together must be below 4 GiB.
[[nodiscard]] GlbShell glb_shell(std::string json, std::size_t binary_bytes);

/// The whole file.
[[nodiscard]] std::string glb_container(std::string json, std::string_view binary);

}  // namespace scanknit
