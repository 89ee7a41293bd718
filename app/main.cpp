#include <malloc.h>

#include "app/cli.h"

namespace {

/// The pictures of a frame are given back and taken again thirty times a second; the kernel would have to clear their
/// pages each time. So malloc keeps some freed memory, and large pieces are its own.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  return scanknit::run_cli(argc, argv);
}
