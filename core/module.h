// Parts that bring many libraries with them are modules: nothing of them is loaded before it is asked for.
#pragma once

#include <string>

#include "core/result.h"

namespace scanknit {

/// What a module gives by its one function, `extern "C" const ModuleEntry* scanknit_module()`. What it offers is plain
/// functions: a name that the room's library has, too, would be that library's.
struct ModuleEntry {
  const char* version;  ///< kVersion of the ScanKnit that the module was built with
  const void* offers;   ///< the struct of functions that open_module() is asked for
};

/// Opens libscanknit_`name`.so and gives ModuleEntry::offers. The file lies in the folder `scanknit` beside this
/// library (installed) or beside this library (built); where it does not, the loader looks where it looks for
/// libraries. It is loaded once and never unloaded. Fast when it is loaded already; safe to call from any thread.
/// Errors (kInternal): the file or a library that it needs is missing, it is no module, or one of another version of
/// ScanKnit. The message names it, and ends with `remedy`, a sentence that says what to do, without its full stop.
[[nodiscard]] Result<const void*> open_module(const std::string& name, const std::string& remedy);

/// The same, typed: `Offers` is the struct that the module's entry points to.
template <typename Offers>
[[nodiscard]] Result<const Offers*> load_module(const std::string& name, const std::string& remedy) {
  const auto offers = open_module(name, remedy);
  if (!offers) return offers.error();
  return static_cast<const Offers*>(*offers);
}

}  // namespace scanknit
