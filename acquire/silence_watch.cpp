#include "acquire/silence_watch.h"

#include <algorithm>
#include <utility>

namespace scanknit {

SilenceWatch::Verdict SilenceWatch::look(std::int64_t picture_ns, std::int64_t now_ns) {
  // A computer so busy that it did not look for long has kept pictures from us, too: they may be waiting.
  const bool has_overslept = now_ns - std::exchange(looked_ns_, now_ns) > kSilence.count() / 2;
  if (restarts_ > 0 && picture_ns > started_ns_) {
    restarts_ = 0;
    return Verdict::kRecovered;
  }
  const bool is_silent = now_ns - std::max(picture_ns, started_ns_) > kSilence.count();
  if (has_overslept || !is_silent) return Verdict::kNothing;
  if (restarts_ == kMostRestarts) return Verdict::kGiveUp;
  ++restarts_;
  return Verdict::kRestart;
}

}  // namespace scanknit
