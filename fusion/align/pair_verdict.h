// Whether two scans fit together, and how their pose was found.
#pragma once

namespace scanknit {

enum class PairVerdict { kGood, kAcceptable, kUnacceptable };

/// "good", "acceptable", "unacceptable".
[[nodiscard]] const char* to_string(PairVerdict verdict);

/// The start of a pair's registration.
enum class PairStart {
  kSearch,  ///< the best of a search over all poses
  kPrior,   ///< a pose that was known before
  kOthers,  ///< the poses that the other pairs give
  kGiven,   ///< a final pose: it is measured, not registered
};

/// "search", "prior", "others", "given".
[[nodiscard]] const char* to_string(PairStart start);

}  // namespace scanknit
