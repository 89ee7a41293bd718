// The module libscanknit_stereo_opencv.so.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "acquire/stereo/refine_disparity.h"
#include "acquire/stereo/stereo_opencv.h"
#include "core/median.h"
#include "core/version.h"

namespace scanknit {
namespace {

constexpr int kFraction = 16;  // SGBM's disparities are sixteenths of a pixel
constexpr int kBlock = 5;      // pixels, the side of what is compared

cv::Mat mat_of(const ColourImage& picture) {
  cv::Mat mat(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y) {
    std::memcpy(mat.ptr(y), picture.row(y).data(), picture.row(y).size_bytes());
  }
  return mat;
}

ColourImage picture_of(const cv::Mat& mat) {
  auto picture = ColourImage::uninitialised(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::memcpy(picture.row(y).data(), mat.ptr(y), picture.row(y).size_bytes());
  return picture;
}

cv::Mat grey_of(const cv::Mat& colour) {
  cv::Mat grey;
  cv::cvtColor(colour, grey, cv::COLOR_RGB2GRAY);
  return grey;
}

GreyView view_of(const cv::Mat& grey) {
  CV_Assert(grey.isContinuous());
  return {{grey.data, grey.total()}, grey.cols, grey.rows};
}

cv::Matx33d matrix_of_camera(const CameraIntrinsics& camera) {
  return {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
}

/// Where each pixel of the rectified picture is in the one that was taken.
struct RectifyingMaps {
  cv::Mat x, y;
};

RectifyingMaps maps_of(const StereoCamera& camera, const cv::Matx33d& turn, const cv::Matx34d& projection) {
  RectifyingMaps maps;
  const std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
  cv::initUndistortRectifyMap(matrix_of_camera(camera.intrinsics), distortion, turn, projection,
                              {camera.intrinsics.width, camera.intrinsics.height}, CV_16SC2, maps.x, maps.y);
  return maps;
}

class SgbmMatcher final : public StereoMatcher {
 public:
  SgbmMatcher(const StereoRig& rig, int disparities) : disparities_(disparities) {
    cv::ocl::setUseOpenCL(false);  // else OpenCV looks for devices, for nothing
    if (rig.is_rectified()) {
      pair_ = {rig.left.intrinsics, rig.baseline_m(), Pose::Identity()};
      cx_difference_ = rig.left.intrinsics.cx - rig.right.intrinsics.cx;
    } else {
      rectify(rig);
    }
    // H. Hirschmueller 2008, "Stereo Processing by Semiglobal Matching and Mutual Information", with OpenCV's costs of
    // a block; 8 and 32 are what its manual advises for the two penalties.
    sgbm_ = cv::StereoSGBM::create(first(), disparities_, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock,
                                   /*disp12MaxDiff=*/1, /*preFilterCap=*/31, /*uniquenessRatio=*/10,
                                   /*speckleWindowSize=*/100, /*speckleRange=*/1, cv::StereoSGBM::MODE_SGBM_3WAY);
  }

  [[nodiscard]] const RectifiedPair& pair() const override { return pair_; }

  [[nodiscard]] std::optional<MatchedPair> match(const ColourImage& left, const ColourImage& right) override {
    try {
      const cv::Mat left_colour = rectified(left, maps_left_);
      const cv::Mat left_grey = grey_of(left_colour);
      const cv::Mat right_grey = grey_of(rectified(right, maps_right_));
      return MatchedPair{picture_of(left_colour),
                         in_pixels(disparities_of(left_grey, right_grey), left_grey, right_grey)};
    } catch (const std::exception&) {  // cv::Exception, std::bad_alloc
      return std::nullopt;
    }
  }

  [[nodiscard]] std::optional<PairCheck> check(const ColourImage& left, const ColourImage& right) override {
    try {
      return compare_corners(grey_of(rectified(left, maps_left_)), grey_of(rectified(right, maps_right_)));
    } catch (const std::exception&) {
      return std::nullopt;
    }
  }

 private:
  /// The least disparity, as the pictures have it: that of what is infinitely far.
  [[nodiscard]] int first() const { return static_cast<int>(std::floor(cx_difference_)); }

  void rectify(const StereoRig& rig) {
    const CameraIntrinsics& size = rig.left.intrinsics;
    cv::Matx33d R;
    cv::Vec3d t;
    for (int row = 0; row < 3; ++row) {
      t[row] = rig.T_right_left.translation()(row);
      for (int column = 0; column < 3; ++column) R(row, column) = rig.T_right_left.linear()(row, column);
    }
    const std::vector<double> left(rig.left.distortion.begin(), rig.left.distortion.end());
    const std::vector<double> right(rig.right.distortion.begin(), rig.right.distortion.end());
    cv::Matx33d R_left, R_right;
    cv::Matx34d P_left, P_right;
    cv::Matx44d Q;
    cv::stereoRectify(matrix_of_camera(size), left, matrix_of_camera(rig.right.intrinsics), right,
                      {size.width, size.height}, R, t, R_left, R_right, P_left, P_right, Q, cv::CALIB_ZERO_DISPARITY,
                      /*alpha=*/0, {size.width, size.height});
    pair_.camera = {size.width, size.height, P_left(0, 0), P_left(1, 1), P_left(0, 2), P_left(1, 2)};
    pair_.baseline_m = -P_right(0, 3) / P_right(0, 0);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) pair_.T_left_rectified.linear()(row, column) = R_left(column, row);
    }
    maps_left_ = maps_of(rig.left, R_left, P_left);
    maps_right_ = maps_of(rig.right, R_right, P_right);
  }

  [[nodiscard]] static cv::Mat rectified(const ColourImage& picture, const RectifyingMaps& maps) {
    const cv::Mat taken = mat_of(picture);
    if (maps.x.empty()) return taken;
    cv::Mat straight;
    cv::remap(taken, straight, maps.x, maps.y, cv::INTER_LINEAR);
    return straight;
  }

  /// SGBM gives no disparity to the left border, as wide as its range. A margin before it keeps what both pictures see.
  [[nodiscard]] cv::Mat disparities_of(const cv::Mat& left, const cv::Mat& right) const {
    const int margin = std::max(0, disparities_ + first());
    cv::Mat wide_left, wide_right, found;
    cv::copyMakeBorder(left, wide_left, 0, 0, margin, 0, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(right, wide_right, 0, 0, margin, 0, cv::BORDER_REPLICATE);
    sgbm_->compute(wide_left, wide_right, found);
    return found.colRange(margin, found.cols);
  }

  [[nodiscard]] Image<float> in_pixels(const cv::Mat& found, const cv::Mat& left, const cv::Mat& right) const {
    Image<float> disparity_px(found.cols, found.rows, 0.0F);
    const GreyView left_view = view_of(left);
    const GreyView right_view = view_of(right);
    cv::parallel_for_({0, found.rows}, [&](const cv::Range& rows) {
      for (int y = rows.start; y < rows.end; ++y) {
        for (int x = 0; x < found.cols; ++x) {
          const float disparity = static_cast<float>(found.at<std::int16_t>(y, x)) / kFraction;
          if (disparity < static_cast<float>(first()) || disparity > static_cast<float>(x)) continue;
          const float refined = refine_disparity(left_view, right_view, x, y, disparity);
          if (!is_alike_on_all_sides(left_view, right_view, x, y, refined)) continue;
          if (refined > cx_difference_) disparity_px.at(x, y) = static_cast<float>(refined - cx_difference_);
        }
      }
    });
    return disparity_px;
  }

  /// The place in `right` that looks like the corner: up to the range of disparities to either side, and some rows.
  struct Partner {
    double columns, rows;
  };
  [[nodiscard]] std::optional<Partner> partner_of(const cv::Point& corner, const cv::Mat& left,
                                                  const cv::Mat& right) const {
    constexpr int kHalf = 7, kRows = 8;
    constexpr double kAlike = 0.9;
    const cv::Rect whole(0, 0, left.cols, left.rows);
    const cv::Rect patch(corner.x - kHalf, corner.y - kHalf, 2 * kHalf + 1, 2 * kHalf + 1);
    const int reach = disparities_ + std::abs(first());
    const cv::Rect place =
        cv::Rect(patch.x - reach, patch.y - kRows, patch.width + 2 * reach, patch.height + 2 * kRows) & whole;
    if ((patch & whole) != patch) return std::nullopt;
    cv::Mat likeness;
    cv::matchTemplate(right(place), left(patch), likeness, cv::TM_CCOEFF_NORMED);
    double best = 0;
    cv::Point at;
    cv::minMaxLoc(likeness, nullptr, &best, nullptr, &at);
    if (!(best > kAlike) || at.y == 0 || at.y == likeness.rows - 1) return std::nullopt;
    // The top of the parabola through three rows.
    const double above = likeness.at<float>(at.y - 1, at.x);
    const double below = likeness.at<float>(at.y + 1, at.x);
    const double bend = above + below - 2 * best;
    const double part = bend < 0 ? 0.5 * (above - below) / bend : 0;
    return Partner{static_cast<double>(patch.x - place.x - at.x), at.y + part - (patch.y - place.y)};
  }

  [[nodiscard]] PairCheck compare_corners(const cv::Mat& left, const cv::Mat& right) const {
    constexpr int kMostCorners = 300;
    constexpr double kBehind_px = -1;
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(left, corners, kMostCorners, 0.02, 10);
    std::vector<double> rows;
    std::size_t behind = 0;
    for (const cv::Point2f& corner : corners) {
      const auto partner = partner_of(corner, left, right);
      if (!partner) continue;
      rows.push_back(partner->rows);
      if (partner->columns - cx_difference_ < kBehind_px) ++behind;
    }
    if (rows.empty()) return {};
    const std::size_t count = rows.size();
    return {count, median(std::move(rows)), static_cast<double>(behind) / static_cast<double>(count)};
  }

  int disparities_;
  RectifiedPair pair_;
  double cx_difference_ = 0;  ///< left - right: the disparity of what is infinitely far
  RectifyingMaps maps_left_, maps_right_;
  cv::Ptr<cv::StereoSGBM> sgbm_;
};

std::unique_ptr<StereoMatcher> make_matcher(const StereoRig& rig, int disparities) {
  try {
    auto matcher = std::make_unique<SgbmMatcher>(rig, disparities);
    const RectifiedPair& pair = matcher->pair();
    const bool is_usable =
        pair.camera.is_valid() && pair.camera.fx > 0 && std::isfinite(pair.baseline_m) && pair.baseline_m > 0;
    return is_usable ? std::move(matcher) : nullptr;
  } catch (const std::exception&) {  // cv::Exception, std::bad_alloc
    return nullptr;
  }
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr StereoOpenCv kOffers{make_matcher};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
