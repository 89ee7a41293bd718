#include "scan/frames/fuse_again.h"

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/shutter/deskew.h"
#include "scan/frames/frame_archive.h"

namespace scanknit {

Result<std::size_t> fuse_again(FrameSource& source, const FramesToFuse& frames, const ScanConfig& config,
                               TsdfVolume& volume, ScanSession& session) {
  std::map<std::uint64_t, const PosedFrame*> posed;
  for (const PosedFrame& frame : frames.trajectory) posed[frame.sequence] = &frame;
  const std::size_t wanted = posed.size();
  std::size_t fused = 0;
  if (wanted == 0) return fused;
  const auto read = for_each_frame(source, session.stop(), [&](Frame& frame) -> Result<Reading> {
    const auto found = posed.find(frame.sequence);
    if (found == posed.end()) return Reading::kContinue;
    const auto& [sequence, stamp, T_world_camera, motion] = *found->second;
    if (frames.edit) frames.edit(frame);
    if (auto filtered = filter_frame(frame, config.acquire, config.fusion.noise); !filtered) return filtered.error();
    deskew(motion, frame);
    if (const auto done = integrate(frame, T_world_camera, volume); !done) return done.error();
    session.progress("fusing again", ++fused, wanted);
    return fused < wanted ? Reading::kContinue : Reading::kStop;
  });
  if (!read) return read.error();
  return fused;
}

}  // namespace scanknit
