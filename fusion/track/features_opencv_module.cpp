// The module libscanknit_features_opencv.so.
#include <algorithm>
#include <cmath>
#include <new>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/hal.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/features2d.hpp>

#include "core/version.h"
#include "fusion/track/features_opencv.h"

namespace scanknit {
namespace {

constexpr int kMostFeatures = 600;
constexpr std::size_t kFewestMatches = 12;
constexpr float kBestToSecond = 0.8f;  // Lowe 2004: a match that is hardly better than the next is none
constexpr int kMostBits = 64;          // of 256
constexpr float kReprojection_px = 3.0f;
constexpr int kDraws = 300;

/// The intensity as bytes; black where unknown. `known`: away from the unknown, whose borders look like corners.
struct GreyBytes {
  cv::Mat grey, known;
};

GreyBytes bytes_of(const SurfaceLevel& picture) {
  const int width = picture.intrinsics.width;
  const int height = picture.intrinsics.height;
  GreyBytes bytes{cv::Mat(height, width, CV_8U, cv::Scalar(0)), cv::Mat(height, width, CV_8U, cv::Scalar(0))};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = picture.index(x, y);
      if (!(picture.z_m[i] > 0) || picture.intensity[i] < 0) continue;
      bytes.grey.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(std::clamp(std::lround(255 * picture.intensity[i]), 0L, 255L));
      bytes.known.at<std::uint8_t>(y, x) = 255;
    }
  }
  return bytes;
}

int differing_bits(const Feature& a, const Feature& b) {
  return cv::hal::normHamming(a.descriptor.data(), b.descriptor.data(), static_cast<int>(a.descriptor.size()));
}

const Feature* partner_of(const Feature& feature, const std::vector<Feature>& others) {
  const Feature* best = nullptr;
  int best_bits = kMostBits + 1;
  int second_bits = 256;
  for (const Feature& other : others) {
    const int bits = differing_bits(feature, other);
    if (bits < best_bits) {
      second_bits = best_bits;
      best_bits = bits;
      best = &other;
    } else {
      second_bits = std::min(second_bits, bits);
    }
  }
  return static_cast<float>(best_bits) < kBestToSecond * static_cast<float>(second_bits) ? best : nullptr;
}

Pose pose_of(const cv::Mat& turn, const cv::Mat& shift) {
  cv::Mat rotation;
  cv::Rodrigues(turn, rotation);
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) pose.linear()(row, column) = rotation.at<double>(row, column);
    pose.translation()(row) = shift.at<double>(row);
  }
  return pose;
}

/// OpenCV says it by an exception of its own.
void pass_on_lack_of_memory(const cv::Exception& fault) {
  if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
}

std::vector<Feature> features_in(const SurfaceLevel& picture) {
  std::vector<Feature> features;
  try {
    cv::ocl::setUseOpenCL(false);  // else OpenCV looks for devices, for nothing
    const GreyBytes bytes = bytes_of(picture);
    std::vector<cv::KeyPoint> corners;
    cv::Mat descriptors;
    cv::ORB::create(kMostFeatures)->detectAndCompute(bytes.grey, bytes.known, corners, descriptors);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const int x = cvRound(corners[i].pt.x);
      const int y = cvRound(corners[i].pt.y);
      if (x < 0 || y < 0 || x >= picture.intrinsics.width || y >= picture.intrinsics.height) continue;
      const float z_m = picture.z_m[picture.index(x, y)];
      if (!(z_m > 0)) continue;
      Feature feature;
      std::copy_n(descriptors.ptr<std::uint8_t>(static_cast<int>(i)), feature.descriptor.size(),
                  feature.descriptor.begin());
      feature.pixel = {corners[i].pt.x, corners[i].pt.y};
      feature.p_camera = picture.intrinsics
                             .unproject(static_cast<double>(corners[i].pt.x), static_cast<double>(corners[i].pt.y),
                                        static_cast<double>(z_m))
                             .cast<float>();
      features.push_back(feature);
    }
  } catch (const cv::Exception& fault) {
    pass_on_lack_of_memory(fault);
    features.clear();  // too small a picture: no features
  }
  return features;
}

std::optional<Pose> motion_between(const std::vector<Feature>& from, const std::vector<Feature>& to,
                                   const CameraIntrinsics& to_camera) {
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
  for (const Feature& feature : from) {
    const Feature* partner = partner_of(feature, to);
    if (partner == nullptr) continue;
    points.emplace_back(feature.p_camera.x(), feature.p_camera.y(), feature.p_camera.z());
    pixels.emplace_back(partner->pixel.x(), partner->pixel.y());
  }
  if (points.size() < kFewestMatches) return std::nullopt;
  try {
    const cv::Matx33d camera(to_camera.fx, 0, to_camera.cx, 0, to_camera.fy, to_camera.cy, 0, 0, 1);
    cv::Mat turn, shift;
    std::vector<int> agreeing;
    const bool is_found =
        cv::solvePnPRansac(points, pixels, camera, cv::noArray(), turn, shift, /*useExtrinsicGuess=*/false, kDraws,
                           kReprojection_px, 0.999, agreeing, cv::SOLVEPNP_P3P);
    if (!is_found || agreeing.size() < kFewestMatches) return std::nullopt;
    const Pose T_to_from = pose_of(turn, shift);
    if (!is_rigid(T_to_from)) return std::nullopt;
    return T_to_from.inverse();
  } catch (const cv::Exception& fault) {
    pass_on_lack_of_memory(fault);
    return std::nullopt;  // a degenerate set of points
  }
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr FeaturesOpenCv kOffers{features_in, motion_between};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
