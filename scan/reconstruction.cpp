#include "scan/reconstruction.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/shutter/deskew.h"
#include "fusion/track/feature_match.h"
#include "scan/checks/memory_share.h"
#include "scan/frames/frame_archive.h"
#include "scan/lost_frames.h"

namespace scanknit {

Result<Reconstruction> Reconstruction::create(const ScanConfig& config, const Options& options, PoseRefiner& refiner,
                                              ScanSession& session) {
  if (is_tracked(options.poses)) {
    if (auto found = check_features(); !found) return found.error();
  }
  auto volume = TsdfVolume::create(volume_config(config.fusion));
  if (!volume) return volume.error();
  return Reconstruction(config, options, refiner, session, *std::move(volume));
}

Result<Reconstruction::Added> Reconstruction::add(Frame& frame) {
  const auto filtered =
      session_.timed("filter", [&] { return filter_frame(frame, config_.acquire, config_.fusion.noise); });
  if (!filtered) return filtered.error();
  refiner_.edit_for_tracking(frame);
  auto found = poses_.find(frame, volume_, session_);
  if (found && first_ && !found->motion.is_still()) {
    if (auto begun = begin_again(found->motion); !begun) return begun.error();
    found = poses_.find(frame, volume_, session_);
  }
  first_.reset();
  if (!found) {
    follows_gap_ = true;
    return Added{};
  }
  if (trajectory_.empty() && !config_.acquire.timing().is_at_once()) first_ = frame;
  return fuse(frame, *found);
}

/// The motion during the first frame is known when the second is tracked: takes it out of the first frame.
Result<void> Reconstruction::begin_again(const FrameMotion& motion) {
  Frame first = *std::exchange(first_, std::nullopt);
  if (auto emptied = start_over(); !emptied) return emptied;
  auto found = poses_.find(first, volume_, session_);
  found->motion = motion;
  const auto added = fuse(first, *found);
  return added ? Result<void>() : added.error();
}

Result<IntegrateStats> Reconstruction::integrate_straightened(Frame& frame, const PoseFinder::Found& found) {
  if (!found.motion.is_still()) session_.timed("deskew", [&] { deskew(found.motion, frame); });
  const bool was_full = is_budget_reached();
  auto fused = session_.timed("integrate", [&] { return integrate(frame, found.T_world_camera, volume_); });
  if (is_budget_reached() && !was_full && options_.warns_when_full) {
    session_.warn(WarningCode::kBudgetReached,
                  fmt::format("frame {}: the volume has reached fusion.memory_budget and grows no further; what it "
                              "holds is still refined",
                              frame.sequence));
  }
  return fused;
}

Result<Reconstruction::Added> Reconstruction::fuse(Frame& frame, const PoseFinder::Found& found) {
  const auto fused = integrate_straightened(frame, found);
  if (!fused && fused.error().code == ErrorCode::kInput) return Added{std::nullopt, fused.error()};
  if (!fused) return fused.error();
  note_fused(frame, found);
  return Added{found.T_world_camera};
}

void Reconstruction::note_fused(const Frame& frame, const PoseFinder::Found& found) {
  trajectory_.push_back({frame.sequence, stamp_of(frame), found.T_world_camera, found.motion});
  refiner_.note_fused(frame, found.T_world_camera, std::exchange(follows_gap_, false));
  if (options_.keeps_depth_samples) samples_.add(frame);
}

Result<void> Reconstruction::find_lost(FrameSource& source) {
  std::set<std::uint64_t> lost;
  for (const TrackedFrame& frame : tracking()->frames) {
    if (frame.state == TrackState::kLost) lost.insert(frame.sequence);
  }
  const PosesBySequence known = poses_of(trajectory_);
  LostFrames search({[&](Frame& frame, const std::optional<KnownFrame>& neighbour) -> Result<TrackResult> {
                       if (auto filtered = filter_frame(frame, config_.acquire, config_.fusion.noise); !filtered) {
                         return filtered.error();
                       }
                       return poses_.find_later(frame, volume_, neighbour, session_);
                     },
                     [&](Frame& frame, const TrackResult& found) { return fuse_later(frame, found); }});
  std::size_t searched = 0;
  return for_each_frame(source, session_.stop(), [&](Frame& frame) -> Result<Reading> {
    Result<void> added;
    bool is_last = false;
    if (const auto pose = known.find(frame.sequence); pose != known.end()) {
      added = search.add_known_frame({pose->second, frame.timestamp_ns});
      is_last = searched == lost.size();
    } else if (lost.contains(frame.sequence)) {
      added = search.add_lost_frame(frame);
      session_.progress("looking for lost frames", ++searched, lost.size());
    }
    if (!added) return added.error();
    return is_last ? Reading::kStop : Reading::kContinue;
  });
}

Result<void> Reconstruction::fuse_later(Frame& frame, const TrackResult& found) {
  const auto fused = integrate_straightened(frame, {found.T_world_camera, found.motion});
  if (!fused) return fused.error().code == ErrorCode::kInput ? Result<void>() : fused.error();
  const PosedFrame posed{frame.sequence, stamp_of(frame), found.T_world_camera, found.motion};
  const auto after =
      std::upper_bound(trajectory_.begin(), trajectory_.end(), posed.sequence,
                       [](std::uint64_t sequence, const PosedFrame& other) { return sequence < other.sequence; });
  trajectory_.insert(after, posed);
  fused_later_.push_back(posed.sequence);
  poses_.note_found_later(described(frame, found));
  return {};
}

Result<void> Reconstruction::start_over() {
  auto volume = TsdfVolume::create(volume_config(config_.fusion));
  if (!volume) return volume.error();
  volume_ = *std::move(volume);
  poses_ = PoseFinder(options_.poses, config_.acquire.timing());
  trajectory_.clear();
  fused_later_.clear();
  samples_.clear();
  first_.reset();
  follows_gap_ = false;
  refiner_.start_over();
  return {};
}

void Reconstruction::replace(TsdfVolume volume, Trajectory trajectory, std::span<const TrackedFrame> recovered) {
  for (const TrackedFrame& frame : recovered) poses_.note_found_later(frame);
  volume_ = std::move(volume);
  poses_.forget_views();
  trajectory_ = std::move(trajectory);
  fused_later_.clear();
}

std::vector<std::uint64_t> Reconstruction::fused_order() const {
  const std::set<std::uint64_t> later(fused_later_.begin(), fused_later_.end());
  std::vector<std::uint64_t> order;
  for (const PosedFrame& frame : trajectory_) {
    if (!later.contains(frame.sequence)) order.push_back(frame.sequence);
  }
  order.insert(order.end(), fused_later_.begin(), fused_later_.end());
  return order;
}

VolumeResult described(const TsdfVolume& volume) {
  constexpr double kBytesPerMebibyte = 1024.0 * 1024.0;
  VolumeResult result;
  result.active_voxels = volume.active_voxels();
  result.blocks = volume.blocks();
  result.memory_mib = static_cast<double>(volume.memory_bytes()) / kBytesPerMebibyte;
  result.voxel_size_m = volume.config().voxel_size_m;
  result.is_budget_reached = volume.is_budget_reached;
  return result;
}

}  // namespace scanknit
