#include "scan/scan_result.h"

#include <algorithm>

namespace scanknit {

const ScanWarning* find_warning(const ScanResult& result, WarningCode code) {
  const auto found = std::find_if(result.warnings.begin(), result.warnings.end(),
                                  [&](const ScanWarning& warning) { return warning.code == code; });
  return found == result.warnings.end() ? nullptr : &*found;
}

}  // namespace scanknit
