#include "app/scan/retrack.h"

#include <fmt/format.h>

#include <utility>
#include <variant>

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/track/tracker.h"

namespace scanknit {

Result<std::vector<Pose>> track_alone(FrameSource& source, std::span<const std::uint64_t> sequences,
                                      const Config& config, std::stop_token stop) {
  auto volume = TsdfVolume::create(config.fusion);
  if (!volume) return volume.error();
  Tracker tracker;
  std::vector<Pose> poses;
  while (poses.size() < sequences.size()) {
    FrameEvent event = source.next(stop);
    if (const auto* error = std::get_if<Error>(&event)) return *error;
    if (std::holds_alternative<EndOfStream>(event)) {
      return Error{ErrorCode::kInput, fmt::format("frame {} could not be read again", sequences[poses.size()])};
    }
    auto* frame = std::get_if<Frame>(&event);
    if (frame == nullptr || frame->sequence != sequences[poses.size()]) continue;
    frame->T_world_camera.reset();
    filter_frame(*frame, config.acquire, config.fusion.noise);
    const TrackResult tracked = tracker.track(*frame, *volume);
    if (tracked.is_lost()) break;
    if (const auto fused = integrate(*frame, tracked.T_world_camera, *volume); !fused) return fused.error();
    poses.push_back(tracked.T_world_camera);
  }
  return poses;
}

}  // namespace scanknit
