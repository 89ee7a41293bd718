// A module as it should be.
#include "core/system/module.h"
#include "core/version.h"
#include "tests/core/module_offers.h"

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  static constexpr scanknit::test::ModuleOffers kOffers{[](int number) { return 2 * number; }};
  static constexpr scanknit::ModuleEntry kEntry{scanknit::kVersion, &kOffers};
  return &kEntry;
}
