// Maps the memory of large arrays in one call instead of page by page.
#pragma once

#include <cstddef>

namespace scanknit {

/// A hint before the first write to new memory: for a large mesh, the page faults, one every 4 KB, take longer than all
/// arithmetic. Does not change the contents.
void prefault(void* memory, std::size_t bytes);

}  // namespace scanknit
