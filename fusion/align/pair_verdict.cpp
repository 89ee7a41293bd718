#include "fusion/align/pair_verdict.h"

namespace scanknit {

const char* to_string(PairVerdict verdict) {
  switch (verdict) {
    case PairVerdict::kGood: return "good";
    case PairVerdict::kAcceptable: return "acceptable";
    case PairVerdict::kUnacceptable: return "unacceptable";
  }
  return "unacceptable";
}

const char* to_string(PairStart start) {
  switch (start) {
    case PairStart::kSearch: return "search";
    case PairStart::kPrior: return "prior";
    case PairStart::kOthers: return "others";
    case PairStart::kGiven: return "given";
  }
  return "search";
}

}  // namespace scanknit
