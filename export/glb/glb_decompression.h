// Decompresses EXT_meshopt_compression (https://github.com/KhronosGroup/glTF, extensions/2.0/Vendor). Private to the
// GLB reader.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// The same GLB without EXT_meshopt_compression; nothing when it does not use it. `glb` has passed
/// check_glb_container(). Errors: kInput for data that cannot be decompressed, or that would be larger than is
/// plausible for a file of this size. May throw what nlohmann-json throws.
[[nodiscard]] Result<std::optional<std::string>> without_meshopt(std::string_view glb, const Limits& limits);

}  // namespace scanknit
