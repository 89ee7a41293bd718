#include "app/scan/pose_finder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "core/check.h"

namespace scanknit {
namespace {

void note(const Frame& frame, const TrackResult& result, RunReport& report) {
  RunReport::Tracking& tracking = *report.tracking;
  ++tracking.states[to_string(result.state)];
  if (result.is_lost()) ++report.frames.lost;
  tracking.frames.push_back({.sequence = frame.sequence,
                             .state = to_string(result.state),
                             .reason = result.reason,
                             .overlap = result.overlap,
                             .inlier_share = result.inlier_share,
                             .rms_sigma = result.rms_sigma,
                             .points = result.points,
                             .weak_directions = result.weak_directions});
}

double milliseconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

/// "tracking was lost in 84 of 120 frames (40 x nothing seen; 44 x place not recognised)"
std::string lost_text(const RunReport& report) {
  std::map<std::string, std::size_t> reasons;
  for (const auto& frame : report.tracking->frames) {
    if (frame.state == "lost") ++reasons[frame.reason];
  }
  std::vector<std::string> parts;
  for (const auto& [reason, count] : reasons) parts.push_back(fmt::format("{} x {}", count, reason));
  return fmt::format("tracking was lost in {} of {} frames ({})", report.frames.lost, report.tracking->frames.size(),
                     fmt::join(parts, "; "));
}

bool is_mostly_lost(const RunReport& report) {
  return report.tracking && 2 * report.frames.lost > report.tracking->frames.size();
}

bool is_lost_at_the_end(const RunReport& report) {
  return report.tracking->frames.back().state == to_string(TrackState::kLost);
}

}  // namespace

PoseFinder::PoseFinder(PoseMode mode)
    : mode_(mode), tracker_(mode == PoseMode::kRefine ? PosePrior::kRefine : PosePrior::kIgnore) {
  SCANKNIT_CHECK(mode != PoseMode::kAuto);
}

std::optional<Pose> PoseFinder::find(const Frame& frame, const TsdfVolume& volume, RunReport& report) {
  if (!is_tracked(mode_)) return frame.T_world_camera;
  if (!report.tracking)
    report.tracking = RunReport::Tracking{mode_ == PoseMode::kRefine ? "refine" : "track", {}, {}, {}};
  const auto begin = std::chrono::steady_clock::now();
  const TrackResult result = tracker_.track(frame, volume);
  const auto spent = std::chrono::steady_clock::now() - begin;
  report.stages["track"].samples_ms.push_back(milliseconds(spent - result.raycast_time));
  report.stages["raycast"].samples_ms.push_back(milliseconds(result.raycast_time));
  note(frame, result, report);
  if (result.is_lost()) return std::nullopt;
  return result.T_world_camera;
}

Result<void> check_tracking(const RunReport& report) {
  if (!is_mostly_lost(report)) return {};
  if (report.volume.is_budget_reached) {
    return Error{
        ErrorCode::kBudget,
        lost_text(report) +
            ", and the volume had reached fusion.memory_budget, beyond which there is nothing to track against. "
            "What it holds has been meshed; for more, raise fusion.memory_budget or fusion.voxel_size"};
  }
  if (!is_lost_at_the_end(report)) return {};
  std::string fused;
  if (report.frames.fused > 0) {
    fused = fmt::format(
        ". Of the {} frames that were fused no mesh is made; --save-volume FILE.vdb keeps them for scanknit extract",
        report.frames.fused);
  }
  return Error{ErrorCode::kTooLittle,
               lost_text(report) + "; scan more slowly, with more of what was already seen in view" + fused};
}

std::optional<std::string> tracking_warning(const RunReport& report) {
  constexpr std::size_t kFew = 10;  // one in so many
  if (!report.tracking || kFew * report.frames.lost <= report.tracking->frames.size()) return std::nullopt;
  return fmt::format("{}{}: the mesh holds only the frames that were fused ({} of {})", lost_text(report),
                     is_lost_at_the_end(report) ? "" : ", and found again", report.frames.fused,
                     report.tracking->frames.size());
}

}  // namespace scanknit
