#include "core/check.h"

#include <cstdio>
#include <cstdlib>

namespace scanknit {

void check_failed(const char* condition, const char* file, int line) noexcept {
  std::fprintf(stderr, "scanknit: internal error: %s:%d: broken promise: %s\n", file, line, condition);
  std::abort();
}

}  // namespace scanknit
