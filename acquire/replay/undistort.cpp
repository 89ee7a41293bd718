#include "acquire/replay/undistort.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace scanknit {
namespace {

template <typename T, typename Lens, typename Sample>
Image<T> resample(const Image<T>& image, const CameraIntrinsics& camera, const Lens& distortion, Sample sample) {
  Image<T> straight(image.width(), image.height());
  tbb::parallel_for(0, image.height(), [&](int y) {
    for (int x = 0; x < image.width(); ++x) {
      const Eigen::Vector2d source = distort_pixel(x, y, camera, distortion);
      // Also false for NaN, so that the conversions to int below are sound.
      const bool is_inside = source.x() > -0.5 && source.y() > -0.5 && source.x() < image.width() - 0.5 &&
                             source.y() < image.height() - 0.5;
      if (is_inside) straight.at(x, y) = sample(image, source);
    }
  });
  return straight;
}

float sample_nearest(const DepthImage& image, const Eigen::Vector2d& at) {
  return image.at(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
}

Rgb8 sample_bilinear(const ColourImage& image, const Eigen::Vector2d& at) {
  const double x = std::clamp(at.x(), 0.0, image.width() - 1.0);
  const double y = std::clamp(at.y(), 0.0, image.height() - 1.0);
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, image.width() - 1);
  const int y1 = std::min(y0 + 1, image.height() - 1);
  const double right = x - x0, below = y - y0;
  const Rgb8 &a = image.at(x0, y0), &b = image.at(x1, y0), &c = image.at(x0, y1), &d = image.at(x1, y1);
  const auto blend = [&](std::uint8_t Rgb8::*channel) {
    const double top = a.*channel + right * (b.*channel - a.*channel);
    const double bottom = c.*channel + right * (d.*channel - c.*channel);
    return static_cast<std::uint8_t>(top + below * (bottom - top) + 0.5);
  };
  return {blend(&Rgb8::r), blend(&Rgb8::g), blend(&Rgb8::b)};
}

}  // namespace

Eigen::Vector2d distort_pixel(double u, double v, const CameraIntrinsics& camera,
                              const RationalDistortion& distortion) {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = distortion;
  const double x = (u - camera.cx) / camera.fx;
  const double y = (v - camera.cy) / camera.fy;
  const double r2 = x * x + y * y;
  double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const bool is_rational = k4 != 0 || k5 != 0 || k6 != 0;
  if (is_rational) radial /= 1 + r2 * (k4 + r2 * (k5 + r2 * k6));  // not by 1, for speed
  const double bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double bent_y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {camera.fx * bent_x + camera.cx, camera.fy * bent_y + camera.cy};
}

Eigen::Vector2d distort_pixel(double u, double v, const CameraIntrinsics& camera, const FisheyeDistortion& distortion) {
  const auto [k1, k2, k3, k4] = distortion.k;
  const double x = (u - camera.cx) / camera.fx;
  const double y = (v - camera.cy) / camera.fy;
  const double r = std::hypot(x, y);
  if (!(r > 0)) return {u, v};  // the middle
  const double theta = std::atan(r);
  const double t2 = theta * theta;
  const double scale = theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)))) / r;
  return {camera.fx * scale * x + camera.cx, camera.fy * scale * y + camera.cy};
}

DepthImage undistort(const DepthImage& depth_m, const CameraIntrinsics& camera, const RationalDistortion& distortion) {
  return resample(depth_m, camera, distortion, sample_nearest);
}

ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera, const RationalDistortion& distortion) {
  return resample(colour, camera, distortion, sample_bilinear);
}

DepthImage undistort(const DepthImage& depth_m, const CameraIntrinsics& camera, const FisheyeDistortion& distortion) {
  return resample(depth_m, camera, distortion, sample_nearest);
}

ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera, const FisheyeDistortion& distortion) {
  return resample(colour, camera, distortion, sample_bilinear);
}

}  // namespace scanknit
