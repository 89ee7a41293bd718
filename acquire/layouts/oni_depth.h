// Depth pictures as OpenNI's recorder packs them ("16zP" and "16zT"). Private to the room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// Every value is a step from the one before it: small ones share a byte, long runs of "no step" have bytes of their
/// own. With a table, what is packed are places in the table of values that the picture begins with. Errors (kInput,
/// without `where`): not exactly `pixels` values, a place outside the table.
[[nodiscard]] Result<std::vector<std::uint16_t>> unpack_oni_depth(std::span<const std::byte> packed, bool has_table,
                                                                  std::size_t pixels);

}  // namespace scanknit
