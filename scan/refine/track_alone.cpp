#include "scan/refine/track_alone.h"

#include <fmt/format.h>

#include <utility>

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/shutter/deskew.h"
#include "scan/checks/memory_share.h"
#include "scan/frames/frame_archive.h"

namespace scanknit {

Result<LoneTracker> LoneTracker::create(const ScanConfig& config, const FrameMotion& first) {
  auto volume = TsdfVolume::create(volume_config(config.fusion));
  if (!volume) return volume.error();
  return LoneTracker(config, first, *std::move(volume));
}

Result<TrackResult> LoneTracker::add(Frame& frame) {
  frame.T_world_camera.reset();
  if (auto filtered = filter_frame(frame, config_->acquire, config_->fusion.noise); !filtered) return filtered.error();
  TrackResult tracked = tracker_.track(frame, volume_);
  if (first_) tracked.motion = *std::exchange(first_, std::nullopt);
  if (tracked.is_lost()) return tracked;
  deskew(tracked.motion, frame);
  if (const auto fused = integrate(frame, tracked.T_world_camera, volume_); !fused) return fused.error();
  return tracked;
}

Result<std::vector<Pose>> track_alone(FrameSource& source, std::span<const std::uint64_t> sequences,
                                      const FrameMotion& first, const ScanConfig& config, const std::stop_token& stop) {
  auto tracker = LoneTracker::create(config, first);
  if (!tracker) return tracker.error();
  std::vector<Pose> poses;
  bool is_lost = false;
  if (sequences.empty()) return poses;
  const auto read = for_each_frame(source, stop, [&](Frame& frame) -> Result<Reading> {
    if (frame.sequence != sequences[poses.size()]) return Reading::kContinue;
    const auto tracked = tracker->add(frame);
    if (!tracked) return tracked.error();
    is_lost = tracked->is_lost();
    if (is_lost) return Reading::kStop;
    poses.push_back(tracked->T_world_camera);
    return poses.size() < sequences.size() ? Reading::kContinue : Reading::kStop;
  });
  if (!read) return read.error();
  if (!is_lost && poses.size() < sequences.size()) {
    return Error{ErrorCode::kInput, fmt::format("frame {} could not be read again", sequences[poses.size()])};
  }
  return poses;
}

}  // namespace scanknit
