#include "scan/job/open_job.h"

#include <utility>

#include "scan/frames/recorded_frames.h"
#include "scan/scan_observer.h"
#include "scan/scan_session.h"

namespace scanknit {

Result<OpenJob> open_job(const std::filesystem::path& folder, ScanJob job) {
  auto opened = JobFolder::open(folder);
  if (!opened) return opened.error();
  job.input = opened->recording();
  job.config.acquire.from = opened->header().from;
  job.config.acquire.to = opened->header().to;
  job.config.acquire.every = opened->header().every;
  ScanObserver silent;  // plan_job() told it already
  ScanSession session(silent, {});
  if (const auto first = open_first(job, session); !first) return first.error();
  auto planned = opened->planned(job.config.fusion);
  if (!planned) return planned.error();
  if (const FrameTiming timing = planned->tracked.timing; !timing.is_at_once()) {
    job.config.acquire.readout_s = timing.readout_s;
    job.config.acquire.colour_later_s = timing.colour_later_s;
  }
  return OpenJob{*std::move(opened), std::move(job), *std::move(planned)};
}

}  // namespace scanknit
