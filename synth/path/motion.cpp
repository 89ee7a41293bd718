#include "synth/path/motion.h"

#include "core/check.h"
#include "synth/path/hand_motion.h"

namespace scanknit {

Motion make_motion(const CameraPath& path, const MotionConfig& config) {
  SCANKNIT_CHECK(config.frames >= 1 && config.frames_per_second > 0);
  if (config.kind == PathKind::kScene) return [path, frames = config.frames](double at) { return path(at / frames); };
  return HandMotion(path, config);
}

}  // namespace scanknit
