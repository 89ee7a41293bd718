#include "scan/frames/fuse_again.h"

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"
#include "scan/frames/frame_archive.h"

namespace scanknit {

Result<std::size_t> fuse_again(FrameSource& source, const FramesToFuse& frames, const ScanConfig& config,
                               TsdfVolume& volume, ScanSession& session) {
  const std::size_t wanted = frames.T_world_camera.size();
  std::size_t fused = 0;
  if (wanted == 0) return fused;
  const auto read = for_each_frame(source, session.stop(), [&](Frame& frame) -> Result<Reading> {
    const auto pose = frames.T_world_camera.find(frame.sequence);
    if (pose == frames.T_world_camera.end()) return Reading::kContinue;
    if (frames.edit) frames.edit(frame);
    if (auto filtered = filter_frame(frame, config.acquire, config.fusion.noise); !filtered) return filtered.error();
    if (const auto done = integrate(frame, pose->second, volume); !done) return done.error();
    session.progress("fusing again", ++fused, wanted);
    return fused < wanted ? Reading::kContinue : Reading::kStop;
  });
  if (!read) return read.error();
  return fused;
}

}  // namespace scanknit
