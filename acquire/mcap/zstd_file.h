// Files that zstd packed as a whole.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "acquire/mcap/random_access.h"
#include "core/result.h"

namespace scanknit {

/// The first bytes of what a packed file holds, at most `count`; empty: it is not packed by zstd, or damaged there.
[[nodiscard]] std::vector<std::byte> zstd_front(const RandomAccess& packed, std::size_t count);

/// A file without a name in the folder for temporary files, which is gone when it is closed. What comes before a tear
/// is unpacked; `is_whole` says whether there is one. Errors (kInput, without `where`): the folder has no room for it,
/// or it would be more than a thousand times as large.
struct UnpackedFile {
  std::unique_ptr<RandomAccess> file;
  bool is_whole = true;
};
[[nodiscard]] Result<UnpackedFile> unpack_zstd_file(const RandomAccess& packed);

}  // namespace scanknit
