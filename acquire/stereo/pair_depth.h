// PairDepth: the depth of pairs of pictures of one rig, from a recording or a scanner. Private to the room.
#pragma once

#include <memory>
#include <optional>

#include "acquire/frame_source.h"
#include "acquire/raw_frame.h"
#include "acquire/stereo/stereo_opencv.h"
#include "acquire/stereo/stereo_rig.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// Any thread, one call at a time.
class PairDepth {
 public:
  struct Found {
    DepthImage depth_m;      ///< of the left picture
    ColourImage left;        ///< rectified
    double share_known = 0;  ///< of the pixels; below kLeastKnown the two pictures tell nothing
  };
  static constexpr double kLeastKnown = 0.01;

  /// `rig` states its pictures' size; depth nearer than `min_depth_m` is not looked for. Errors: the rig cannot be
  /// rectified (kInput), OpenCV's module is missing (kInternal).
  [[nodiscard]] static Result<std::unique_ptr<PairDepth>> create(const StereoRig& rig,
                                                                 std::optional<double> min_depth_m);

  /// Of a scanner's own pair (PixelFormat::kY8i), which is rectified. Error also (kDevice): `calibration` tells no
  /// baseline.
  [[nodiscard]] static Result<std::unique_ptr<PairDepth>> create(const RawCalibration& calibration,
                                                                 std::optional<double> min_depth_m);

  [[nodiscard]] const RectifiedPair& pair() const { return matcher_->pair(); }

  /// Both pictures have the cameras' size. Nothing: OpenCV failed.
  [[nodiscard]] std::optional<Found> find(const ColourImage& left, const ColourImage& right) const;
  [[nodiscard]] std::optional<PairCheck> check(const ColourImage& left, const ColourImage& right) const {
    return matcher_->check(left, right);
  }

  /// The rig's own noise: its error in depth is that of its disparities, which grows with the square of the distance.
  [[nodiscard]] RecognisedSensor sensor() const;

 private:
  explicit PairDepth(std::unique_ptr<StereoMatcher> matcher) : matcher_(std::move(matcher)) {}

  std::unique_ptr<StereoMatcher> matcher_;
};

}  // namespace scanknit
