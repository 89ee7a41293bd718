#include "scan/refine/track_alone.h"

#include <fmt/format.h>

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/shutter/deskew.h"
#include "fusion/track/tracker.h"
#include "scan/frames/frame_archive.h"

namespace scanknit {

Result<std::vector<Pose>> track_alone(FrameSource& source, std::span<const std::uint64_t> sequences,
                                      const ScanConfig& config, const std::stop_token& stop,
                                      const OnTrackedAlone& on_tracked) {
  auto volume = TsdfVolume::create(config.fusion);
  if (!volume) return volume.error();
  Tracker tracker({.timing = config.acquire.timing()});
  std::vector<Pose> poses;
  bool is_lost = false;
  if (sequences.empty()) return poses;
  const auto read = for_each_frame(source, stop, [&](Frame& frame) -> Result<Reading> {
    if (frame.sequence != sequences[poses.size()]) return Reading::kContinue;
    frame.T_world_camera.reset();
    if (auto filtered = filter_frame(frame, config.acquire, config.fusion.noise); !filtered) return filtered.error();
    const TrackResult tracked = tracker.track(frame, *volume);
    is_lost = tracked.is_lost();
    if (is_lost) return Reading::kStop;
    deskew(tracked.motion, frame);
    if (const auto fused = integrate(frame, tracked.T_world_camera, *volume); !fused) return fused.error();
    poses.push_back(tracked.T_world_camera);
    if (on_tracked) on_tracked(frame, tracked);
    return poses.size() < sequences.size() ? Reading::kContinue : Reading::kStop;
  });
  if (!read) return read.error();
  if (!is_lost && poses.size() < sequences.size()) {
    return Error{ErrorCode::kInput, fmt::format("frame {} could not be read again", sequences[poses.size()])};
  }
  return poses;
}

}  // namespace scanknit
