// What OpenCV does for stereo pairs: in a module, libscanknit_stereo_opencv.so, which only they need.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "acquire/stereo/stereo_rig.h"
#include "core/image.h"
#include "core/system/module.h"

namespace scanknit {

/// The pair after rectification: two cameras that differ in their place on the rows' axis alone.
struct RectifiedPair {
  CameraIntrinsics camera;  ///< the left one
  double baseline_m = 0;
  Pose T_left_rectified = Pose::Identity();  ///< a turn: the identity if the pictures are rectified already
};

struct MatchedPair {
  ColourImage left;           ///< rectified
  Image<float> disparity_px;  ///< f * baseline / depth, of the left picture's pixels; 0: not known
};

/// How corners of the left picture lie in the right one.
struct PairCheck {
  std::size_t corners = 0;  ///< found in both pictures without doubt
  double rows_px = 0;       ///< median of the rows from the left to the right picture; 0 if rectified well
  double share_behind = 0;  ///< of corners whose disparity is below zero: 1 if left and right are exchanged
};

/// Any thread, one call at a time.
class StereoMatcher {
 public:
  virtual ~StereoMatcher() = default;
  [[nodiscard]] virtual const RectifiedPair& pair() const = 0;
  /// Both pictures have the cameras' sizes. The same bits for any number of threads. Nothing: OpenCV failed.
  [[nodiscard]] virtual std::optional<MatchedPair> match(const ColourImage& left, const ColourImage& right) = 0;
  [[nodiscard]] virtual std::optional<PairCheck> check(const ColourImage& left, const ColourImage& right) = 0;
};

struct StereoOpenCv {
  /// A matcher for a rig whose cameras state their size. It finds disparities from 0 to `disparities` pixels, a
  /// multiple of 16. Null: the rig cannot be rectified.
  std::unique_ptr<StereoMatcher> (*make_matcher)(const StereoRig& rig, int disparities);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const StereoOpenCv*> load_stereo_opencv() {
  return load_module<StereoOpenCv>("stereo_opencv", "Install scanknit again; it needs Debian's libopencv-calib3d406");
}

}  // namespace scanknit
