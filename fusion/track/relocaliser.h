// Relocaliser: finds the camera again by places that were seen before.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "fusion/register/surface_pyramid.h"
#include "fusion/track/feature_match.h"
#include "fusion/track/ferns.h"

namespace scanknit {

class Relocaliser {
 public:
  /// Keeps the frame as a key frame unless it looks like an existing one.
  void learn(const SurfacePyramid& frame, const Pose& T_world_camera);

  [[nodiscard]] std::size_t key_frames() const { return keys_.size(); }
  [[nodiscard]] std::size_t key_frames_with_features() const;

  /// Poses of the key frames that look most like `frame`, the most similar first.
  [[nodiscard]] std::vector<Pose> similar_poses(const SurfacePyramid& frame) const;

  /// Poses from common features with the most similar key frames: slower, but also finds views from other positions.
  [[nodiscard]] std::vector<Pose> matched_poses(const SurfacePyramid& frame) const;

 private:
  struct KeyFrame {
    FernCode code;
    Pose T_world_camera;
    std::vector<Feature> features;  ///< none if a near view's features are kept
  };
  [[nodiscard]] bool has_features_near(const Pose& T_world_camera, double depth_m) const;
  [[nodiscard]] std::vector<const KeyFrame*> most_alike(const SurfacePyramid& frame, std::size_t count,
                                                        bool with_features) const;

  std::optional<Ferns> ferns_;
  std::vector<KeyFrame> keys_;
};

}  // namespace scanknit
