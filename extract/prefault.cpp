#include "extract/prefault.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

namespace scanknit {

void prefault(void* memory, std::size_t bytes) {
#ifdef MADV_POPULATE_WRITE  // Linux 5.14; an older kernel says no, and the pages come one by one
  static const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + page - 1) / page * page;
  const std::uintptr_t last = (begin + bytes) / page * page;
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_POPULATE_WRITE);
#endif
}

}  // namespace scanknit
