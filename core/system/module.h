// Modules: parts that need many libraries. They are loaded only when they are used.
#pragma once

#include <string>

#include "core/result.h"

namespace scanknit {

/// The result of a module's only function, `extern "C" const ModuleEntry* scanknit_module()`. A module offers plain
/// functions: if the room's library had a function of the same name, that one would be called instead.
struct ModuleEntry {
  const char* version;  ///< kVersion of the ScanKnit that the module was built with
  const void* offers;   ///< the struct of functions that open_module() returns
};

/// Opens libscanknit_`name`.so and returns ModuleEntry::offers. The file is in the folder `scanknit` next to this
/// library (installed) or next to this library (built); otherwise the loader searches where it searches for libraries.
/// Opens it once and never unloads it; fast once it is loaded; any thread may call this.
/// Errors (kInternal): the file or a library that it needs is missing, it is no module, or it is of another version of
/// ScanKnit. The message names it and ends with `remedy`, a sentence that says what to do, without its full stop.
[[nodiscard]] Result<const void*> open_module(const std::string& name, const std::string& remedy);

/// The same, typed: `Offers` is the struct that the module's entry points to.
template <typename Offers>
[[nodiscard]] Result<const Offers*> load_module(const std::string& name, const std::string& remedy) {
  const auto offers = open_module(name, remedy);
  if (!offers) return offers.error();
  return static_cast<const Offers*>(*offers);
}

}  // namespace scanknit
