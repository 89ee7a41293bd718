// KeyFrames: frames of a walk that represent their neighbours, kept in the form that registration uses.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/frame.h"
#include "core/noise_model.h"
#include "core/pose.h"
#include "fusion/register/surface_pyramid.h"
#include "fusion/track/feature_match.h"
#include "fusion/track/ferns.h"

namespace scanknit {

/// The length of the camera's path so far.
struct PathLength {
  double walked_m = 0, turned_rad = 0;
  int gaps = 0;  ///< times that tracking was lost
};

struct KeyFrame {
  std::size_t frame;    ///< index of the frame among those that were fused
  Pose T_world_camera;  ///< as tracked
  PathLength path;      ///< path up to this frame
  double depth_m;       ///< typical depth of the picture
  SurfacePyramid seen;
  std::vector<Feature> features;
  FernCode code;
};

class KeyFrames {
 public:
  /// Keeps at most `most` key frames: for a longer walk it drops every other one and takes fewer from then on. A key
  /// frame of 640 x 480 pixels takes about 3 MB.
  explicit KeyFrames(const NoiseModel& noise, std::size_t most = 200) : noise_(noise), most_(most) {}

  /// Adds a frame that was fused, in order. `follows_gap`: tracking was lost since the last one.
  void add(const Frame& frame, const Pose& T_world_camera, bool follows_gap);

  [[nodiscard]] const std::vector<KeyFrame>& kept() const { return kept_; }

  /// Replaces the poses of the frames from `first` on by `T_first_frames`, in the first one's axes; moves all later
  /// frames along with the last of them.
  void replace(std::size_t first, const std::vector<Pose>& T_first_frames);

  /// Without frames; it chooses and describes key frames as this one does, so that insert() can take them.
  [[nodiscard]] KeyFrames without_frames() const;

  /// The last frame becomes the first.
  void reverse();

  /// Where tracking was lost: before the first inserted frame, and between the last one and the frame after it.
  struct Gaps {
    bool before = false, after = false;
  };

  /// Inserts the frames of `found`, which without_frames() began, before the frame of index `at`, or at the end; their
  /// poses become `T_world_frames`, one for each.
  void insert(std::size_t at, KeyFrames found, const std::vector<Pose>& T_world_frames, const Gaps& gaps);

  /// Whether tracking was lost between this frame and the one before it. `frame` may be the number of frames: false.
  [[nodiscard]] bool follows_gap(std::size_t frame) const { return frame < walk_.size() && follows_gap_[frame]; }

  /// Poses of all frames that were added.
  [[nodiscard]] const std::vector<Pose>& walk() const { return walk_; }

 private:
  [[nodiscard]] bool is_new_place(const Pose& T_world_camera) const;
  void thin_out();
  void walk_on_to(std::size_t frame);

  NoiseModel noise_;
  std::size_t most_;
  double spacing_ = 1;  ///< grows with a long walk
  PathLength path_;
  std::optional<Ferns> ferns_;
  std::vector<KeyFrame> kept_;
  std::vector<Pose> walk_;
  std::vector<bool> follows_gap_;  ///< of each frame in walk_
};

}  // namespace scanknit
