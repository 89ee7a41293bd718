#include "app/scan/fuse_again.h"

#include <variant>

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"

namespace scanknit {

Result<std::size_t> fuse_again(FrameSource& source, const PosesBySequence& T_world_camera, const Config& config,
                               TsdfVolume& volume, std::stop_token stop, Console& console, const FrameEdit& edit) {
  std::size_t fused = 0;
  while (fused < T_world_camera.size()) {
    FrameEvent event = source.next(stop);
    if (std::holds_alternative<EndOfStream>(event)) break;
    if (const auto* error = std::get_if<Error>(&event)) return *error;
    auto* frame = std::get_if<Frame>(&event);
    if (frame == nullptr) continue;
    const auto pose = T_world_camera.find(frame->sequence);
    if (pose == T_world_camera.end()) continue;
    if (edit) edit(*frame);
    filter_frame(*frame, config.acquire, config.fusion.noise);
    if (const auto done = integrate(*frame, pose->second, volume); !done) return done.error();
    console.progress("fusing again", ++fused, T_world_camera.size());
  }
  return fused;
}

}  // namespace scanknit
