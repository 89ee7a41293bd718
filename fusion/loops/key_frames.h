// KeyFrames: frames of a walk that stand for their neighbours, kept as registration reads them.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/frame.h"
#include "core/noise_model.h"
#include "core/pose.h"
#include "fusion/loops/feature_match.h"
#include "fusion/loops/ferns.h"
#include "fusion/track/surface_pyramid.h"

namespace scanknit {

/// How far a camera has come.
struct Way {
  double walked_m = 0, turned_rad = 0;
  int gaps = 0;  ///< times that tracking was lost
};

struct KeyFrame {
  std::size_t frame;    ///< index of the frame among those that were fused
  Pose T_world_camera;  ///< as tracked
  Way way;              ///< until here
  double depth_m;       ///< typical, of what it sees
  SurfacePyramid seen;
  std::vector<Feature> features;
  FernCode code;
};

class KeyFrames {
 public:
  /// At most `most` are held: of a longer walk every other one is let go, and fewer are taken. A key frame of 640 x 480
  /// pixels takes about 3 MB.
  explicit KeyFrames(const NoiseModel& noise, std::size_t most = 200) : noise_(noise), most_(most) {}

  /// A frame that was fused, in order. `follows_gap`: tracking was lost since the last one.
  void add(const Frame& frame, const Pose& T_world_camera, bool follows_gap);

  [[nodiscard]] const std::vector<KeyFrame>& kept() const { return kept_; }

  /// Other poses for the frames from `first` on, one for each of `T_first_frames` in the first one's axes; those that
  /// come after them are taken along.
  void replace(std::size_t first, const std::vector<Pose>& T_first_frames);

  /// Poses of all frames that were added.
  [[nodiscard]] const std::vector<Pose>& walk() const { return walk_; }

 private:
  [[nodiscard]] bool is_new_place(const Pose& T_world_camera) const;
  void thin_out();

  NoiseModel noise_;
  std::size_t most_;
  double spacing_ = 1;  ///< grows when the walk is long
  Way way_;
  std::optional<Ferns> ferns_;
  std::vector<KeyFrame> kept_;
  std::vector<Pose> walk_;
};

}  // namespace scanknit
