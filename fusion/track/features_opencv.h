// What OpenCV does for this room: in a module, libscanknit_features_opencv.so, which only tracked scans need.
#pragma once

#include <optional>
#include <vector>

#include "core/system/module.h"
#include "fusion/track/feature_match.h"

namespace scanknit {

struct FeaturesOpenCv {
  /// As find_features() and match_features().
  std::vector<Feature> (*find)(const SurfaceLevel& picture);
  std::optional<Pose> (*match)(const std::vector<Feature>& from, const std::vector<Feature>& to,
                               const CameraIntrinsics& to_camera);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const FeaturesOpenCv*> load_features_opencv() {
  return load_module<FeaturesOpenCv>("features_opencv",
                                     "Install scanknit again; it needs Debian's libopencv-calib3d406");
}

}  // namespace scanknit
