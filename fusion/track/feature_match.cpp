#include "fusion/track/feature_match.h"

#include "fusion/track/features_opencv.h"

namespace scanknit {

Result<void> check_features() {
  const auto module = load_features_opencv();
  return module ? Result<void>() : module.error();
}

std::vector<Feature> find_features(const SurfaceLevel& picture) {
  const auto module = load_features_opencv();
  return module ? (*module)->find(picture) : std::vector<Feature>();
}

std::optional<Pose> match_features(const std::vector<Feature>& from, const std::vector<Feature>& to,
                                   const CameraIntrinsics& to_camera) {
  const auto module = load_features_opencv();
  return module ? (*module)->match(from, to, to_camera) : std::nullopt;
}

}  // namespace scanknit
