#include "acquire/stereo/pair_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scanknit {
namespace {

constexpr double kDisparityNoise_px = 0.2;  // what SGBM does not miss altogether: docs/stereo.md has the figures
constexpr double kNoiseFloor_m = 0.0005;
constexpr double kNearest_m = 0.3;  // where acquire.min_depth does not say it

/// The disparity of the nearest depth that is looked for, as a multiple of 16. Unless asked for, at most a quarter of
/// the picture, and 256 pixels.
int disparities_of(const StereoRig& rig, std::optional<double> min_depth_m) {
  constexpr int kStep = 16;
  const bool is_asked = min_depth_m.value_or(0) > 0;
  const int width = rig.left.intrinsics.width;
  const double most = is_asked ? std::min(width / 2, 1024) : std::min(width / 4, 256);
  const double nearest_m = is_asked ? *min_depth_m : kNearest_m;
  const double wanted = std::min(rig.left.intrinsics.fx * rig.baseline_m() / nearest_m + 1, most);
  return std::max(1, static_cast<int>(std::ceil(wanted / kStep))) * kStep;
}

DepthImage depth_of(const Image<float>& disparity_px, const RectifiedPair& pair) {
  const double scale = pair.camera.fx * pair.baseline_m;
  auto depth_m = DepthImage::uninitialised(disparity_px.width(), disparity_px.height());
  std::transform(disparity_px.pixels().begin(), disparity_px.pixels().end(), depth_m.pixels().begin(),
                 [&](float disparity) { return disparity > 0 ? static_cast<float>(scale / disparity) : 0.0F; });
  return depth_m;
}

}  // namespace

Result<std::unique_ptr<PairDepth>> PairDepth::create(const StereoRig& rig, std::optional<double> min_depth_m) {
  const auto opencv = load_stereo_opencv();
  if (!opencv) return opencv.error();
  auto matcher = (*opencv)->make_matcher(rig, disparities_of(rig, min_depth_m));
  if (!matcher) {
    return Error{ErrorCode::kInput, "the rig's pictures cannot be rectified: check the cameras and their places",
                 rig.file.string()};
  }
  return std::unique_ptr<PairDepth>(new PairDepth(std::move(matcher)));
}

Result<std::unique_ptr<PairDepth>> PairDepth::create(const RawCalibration& calibration,
                                                     std::optional<double> min_depth_m) {
  const CameraIntrinsics& camera = calibration.depth.intrinsics;
  const bool is_rectified = calibration.depth.distortion == Distortion{};
  if (!camera.is_valid() || !is_rectified || !(calibration.baseline_m > 0 && calibration.baseline_m <= 10)) {
    return Error{ErrorCode::kDevice,
                 "the cameras of its pairs of pictures, or the baseline between them, are not known: no depth can be "
                 "made of them",
                 calibration.device};
  }
  StereoRig rig{.left = {camera}, .right = {camera}};
  rig.T_right_left.translation().x() = -calibration.baseline_m;
  return create(rig, min_depth_m);
}

std::optional<PairDepth::Found> PairDepth::find(const ColourImage& left, const ColourImage& right) const {
  auto matched = matcher_->match(left, right);
  if (!matched) return std::nullopt;
  const auto pixels = matched->disparity_px.pixels();
  const auto known = std::count_if(pixels.begin(), pixels.end(), [](float d) { return d > 0; });
  return Found{depth_of(matched->disparity_px, pair()), std::move(matched->left),
               static_cast<double>(known) / static_cast<double>(pixels.size())};
}

RecognisedSensor PairDepth::sensor() const {
  const double scale = pair().camera.fx * pair().baseline_m;
  return {.model = SensorModel::kNone,
          .reason = fmt::format("a stereo rig with a baseline of {:.4g} cm and a focal length of {:.4g} pixels, with "
                                "disparities to {} pixel",
                                100 * pair().baseline_m, pair().camera.fx, kDisparityNoise_px),
          .own_noise = NoiseModel{.floor_m = kNoiseFloor_m, .growth_per_m = kDisparityNoise_px / scale, .from_m = 0}};
}

}  // namespace scanknit
