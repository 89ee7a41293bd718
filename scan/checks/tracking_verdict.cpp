#include "scan/checks/tracking_verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <vector>

namespace scanknit {
namespace {

/// "tracking was lost in 84 of 120 frames (40 x nothing seen; 44 x place not recognised)"
std::string lost_text(const TrackedScan& scan) {
  std::map<std::string, std::size_t> reasons;
  for (const TrackedFrame& frame : scan.tracking->frames) {
    if (frame.state == TrackState::kLost) ++reasons[to_string(frame.reason)];
  }
  std::vector<std::string> parts;
  for (const auto& [reason, count] : reasons) parts.push_back(fmt::format("{} x {}", count, reason));
  return fmt::format("tracking was lost in {} of {} frames ({})", scan.frames.lost, scan.tracking->frames.size(),
                     fmt::join(parts, "; "));
}

bool is_mostly_lost(const TrackedScan& scan) {
  return scan.tracking && 2 * scan.frames.lost > scan.tracking->frames.size();
}

bool is_lost_at_the_end(const TrackedScan& scan) {
  return scan.tracking->frames.back().state == TrackState::kLost;
}

}  // namespace

Result<void> check_tracking(const TrackedScan& scan) {
  if (!is_mostly_lost(scan)) return {};
  if (scan.is_budget_reached) {
    return Error{
        ErrorCode::kBudget,
        lost_text(scan) +
            ". The volume was full (fusion.memory_budget), and a frame that shows none of it cannot be "
            "tracked. The mesh has what the volume holds; for more, raise fusion.memory_budget or fusion.voxel_size"};
  }
  if (!is_lost_at_the_end(scan)) return {};
  std::string fused;
  if (scan.frames.fused > 0) {
    fused = fmt::format(". No mesh is made of the {} fused frames", scan.frames.fused);
  }
  return Error{ErrorCode::kTooLittle,
               lost_text(scan) + "; scan more slowly, with more of what was already seen in view" + fused};
}

std::optional<std::string> tracking_warning(const TrackedScan& scan) {
  constexpr std::size_t kFew = 10;  // one in so many
  if (!scan.tracking || kFew * scan.frames.lost <= scan.tracking->frames.size()) return std::nullopt;
  return fmt::format("{}{}: the mesh holds only the frames that were fused ({} of {})", lost_text(scan),
                     is_lost_at_the_end(scan) ? "" : ", and found again", scan.frames.fused,
                     scan.tracking->frames.size());
}

}  // namespace scanknit
