// Memory of large arrays, asked for in one call instead of page by page.
#pragma once

#include <cstddef>

namespace scanknit {

/// A hint before the first write to freshly allocated memory: on a large mesh the interrupts for its pages, one every
/// 4 KB, take longer than all arithmetic. Contents do not change.
void prefault(void* memory, std::size_t bytes);

}  // namespace scanknit
