// The outer shell of a GLB file, checked before a library parses it.
#pragma once

#include <string>
#include <string_view>

#include "core/result.h"

namespace scanknit {

/// Refuses (kInput): no GLB 2 header, a header length other than the bytes there are, chunks that do not fit, a JSON
/// chunk nested deeper than `max_depth` (recursive parsers would run out of stack).
[[nodiscard]] Result<void> check_glb_container(std::string_view bytes, int max_depth = 64);

/// The shell round `json` and `binary` (glTF 2.0, 4.4), which are filled up to multiples of four. Together they must
/// stay below 4 GiB.
[[nodiscard]] std::string glb_container(std::string json, std::string binary);

}  // namespace scanknit
