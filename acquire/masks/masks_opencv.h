// What OpenCV does for masks: in a module, libscanknit_masks_opencv.so, which only pictures without masks need.
#pragma once

#include <optional>

#include "acquire/masks/mask_files.h"
#include "core/image.h"
#include "core/system/module.h"

namespace scanknit {

struct MasksOpenCv {
  /// What GrabCut (Rother, Kolmogorov and Blake 2004) cuts out of a picture whose rim is background: `rim_share` of its
  /// sides, below 0.5, at each border. The same bits for any number of threads. Nothing: OpenCV failed, or the picture
  /// is too small.
  std::optional<Mask> (*grab_cut)(const ColourImage& picture, double rim_share);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const MasksOpenCv*> load_masks_opencv() {
  return load_module<MasksOpenCv>("masks_opencv", "Install scanknit again; it needs Debian's libopencv-imgproc406");
}

}  // namespace scanknit
