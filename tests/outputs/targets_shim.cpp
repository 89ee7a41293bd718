// Stands before the program's own libraries (LD_PRELOAD) and keeps Highway from the instruction sets that are better
// than the one that is named, as on a processor without them.
//
//     SCANKNIT_TARGETS=NAME  AVX3, AVX2, SSE4, SSSE3 or EMU128, or what is below it where no code was generated for it
//     SCANKNIT_TARGETS=list  prints the names of those that this processor has, and ends the process
#include <hwy/targets.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace {

/// Highway's better targets have smaller numbers.
template <typename Visit>
void each_target(Visit&& visit) {
  for (std::int64_t target = HWY_EMU128; target > 0; target >>= 1) {
    if ((hwy::SupportedTargets() & target) != 0) visit(target);
  }
}

__attribute__((constructor)) void keep_from_better_targets() {
  const char* given = std::getenv("SCANKNIT_TARGETS");
  if (given == nullptr) return;
  const std::string_view wanted = given;
  if (wanted == "list") {
    each_target([](std::int64_t target) { std::puts(hwy::TargetName(target)); });
    std::fflush(stdout);
    std::_Exit(0);
  }
  std::int64_t better = 0;
  each_target([&](std::int64_t target) {
    if (hwy::TargetName(target) == wanted) better = target - 1;
  });
  if (better == 0) {
    std::fprintf(stderr, "SCANKNIT_TARGETS=%s: this processor has no such instruction set\n", given);
    std::_Exit(2);
  }
  hwy::DisableTargets(better);
}

}  // namespace
