#include "scan/bricks/planned_frames.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "acquire/filter/depth_filter.h"
#include "fusion/shutter/deskew.h"
#include "scan/frames/frame_archive.h"
#include "scan/frames/recorded_frames.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostHeld = 32;  // frames, 2 MB each at 640 x 480

Error has_changed(const ScanJob& job) {
  return {ErrorCode::kInput, "has changed since it was planned: give back what it was, or plan and scan it again",
          job.input.string()};
}

/// A frame of the trajectory that is wanted.
struct Wanted {
  std::uint64_t sequence;
  std::uint32_t number;
};

std::vector<Wanted> wanted_frames(const Trajectory& trajectory, const std::vector<FrameRun>& runs) {
  std::vector<Wanted> wanted;
  for (const FrameRun& run : runs) {
    for (std::uint32_t number = run.first; number <= run.last; ++number) {
      wanted.push_back({trajectory[number - 1].sequence, number});
    }
  }
  return wanted;
}

class NumberedFrames {
 public:
  NumberedFrames(const ScanJob& job, ScanSession& session, const VisitNumbered& visit)
      : job_(job), session_(session), visit_(visit) {}

  [[nodiscard]] Result<bool> read(std::span<const Wanted> wanted) {
    while (!wanted.empty()) {
      const std::size_t ascending = count_ascending(wanted);
      const bool is_held = ascending < std::min(kMostHeld, wanted.size());
      const std::size_t count = is_held ? std::min(kMostHeld, wanted.size()) : ascending;
      const auto done = is_held ? read_held(wanted.first(count)) : read_ascending(wanted.first(count), visit_);
      if (!done || !*done) return done;
      wanted = wanted.subspan(count);
    }
    return true;
  }

 private:
  /// Of the first frames, those that the recording has in this order.
  [[nodiscard]] static std::size_t count_ascending(std::span<const Wanted> wanted) {
    std::size_t count = 1;
    while (count < wanted.size() && wanted[count].sequence > wanted[count - 1].sequence) ++count;
    return count;
  }

  [[nodiscard]] Result<bool> read_held(std::span<const Wanted> wanted) {
    std::vector<Wanted> ordered(wanted.begin(), wanted.end());
    std::sort(ordered.begin(), ordered.end(), [](const Wanted& a, const Wanted& b) { return a.sequence < b.sequence; });
    std::vector<std::pair<std::uint32_t, Frame>> held;
    const auto done = read_ascending(ordered, [&](Frame& frame, std::uint32_t number) {
      held.emplace_back(number, std::move(frame));
      return Result<void>();
    });
    if (!done || !*done) return done;
    std::sort(held.begin(), held.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [number, frame] : held) {
      if (session_.is_stopped()) return false;
      if (auto visited = visit_(frame, number); !visited) return visited.error();
    }
    return true;
  }

  [[nodiscard]] Result<bool> read_ascending(std::span<const Wanted> wanted, const VisitNumbered& visit) const {
    SequenceRanges only;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (i > 0 && wanted[i].number != wanted[i - 1].number + 1) only.cut();
      only.add(wanted[i].sequence);
    }
    const auto source = open_frames(job_, &only);
    if (!source) return source.error();
    std::size_t next = 0;
    const auto read = for_each_frame(**source, session_.stop(), [&](Frame& frame) -> Result<Reading> {
      if (frame.sequence < wanted[next].sequence) return Reading::kContinue;
      if (frame.sequence > wanted[next].sequence) return has_changed(job_);
      if (auto visited = visit(frame, wanted[next].number); !visited) return visited.error();
      return ++next < wanted.size() ? Reading::kContinue : Reading::kStop;
    });
    if (!read) return read.error();
    if (next == wanted.size()) return true;
    if (session_.is_stopped()) return false;
    return has_changed(job_);
  }

  const ScanJob& job_;
  ScanSession& session_;
  const VisitNumbered& visit_;
};

}  // namespace

Result<bool> for_each_numbered(const ScanJob& job, const Trajectory& trajectory, const std::vector<FrameRun>& runs,
                               ScanSession& session, const VisitNumbered& visit) {
  return NumberedFrames(job, session, visit).read(wanted_frames(trajectory, runs));
}

Result<bool> for_each_planned(const ScanJob& job, const PlannedScan& planned, const std::vector<FrameRun>& runs,
                              ScanSession& session, const VisitNumbered& visit) {
  ScanJob reading = job;
  if (planned.poses == PoseOrigin::kPlan) reading.config.acquire.poses = PoseMode::kStill;  // whatever the recording's
  return for_each_numbered(reading, planned.trajectory, runs, session,
                           [&](Frame& frame, std::uint32_t number) -> Result<void> {
                             if (checksum_of(frame, planned.poses) != planned.checksums[number - 1])
                               return has_changed(job);
                             const FrameMotion& motion = planned.trajectory[number - 1].motion;
                             if (auto prepared = prepare(frame, motion, job.config, session); !prepared)
                               return prepared;
                             return visit(frame, number);
                           });
}

Result<void> prepare(Frame& frame, const FrameMotion& motion, const ScanConfig& config, ScanSession& session) {
  auto filtered = session.timed("filter", [&] { return filter_frame(frame, config.acquire, config.fusion.noise); });
  if (filtered && !motion.is_still()) session.timed("deskew", [&] { deskew(motion, frame); });
  return filtered;
}

}  // namespace scanknit
