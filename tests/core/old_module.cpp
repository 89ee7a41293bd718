// A module of another version.
#include "core/system/module.h"

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  static constexpr scanknit::ModuleEntry kEntry{"0.0.1-old", nullptr};
  return &kEntry;
}
