#include "acquire/replay/undistort.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <utility>
#include <variant>
#include <vector>

namespace scanknit {
namespace {

using Lens = std::variant<RationalDistortion, FisheyeDistortion>;

/// Where a pixel of the straight picture is in the distorted one: pixel (x, y), and the way on to its neighbours.
struct Place {
  double right, below;  ///< 0 to 1
  std::int32_t x, y;    ///< x < 0: outside of the picture
};

/// Of all pixels, row by row.
using Places = std::vector<Place>;

Place place_of(const Eigen::Vector2d& at, const CameraIntrinsics& camera) {
  // Also false for NaN, so that the conversions to int below are sound.
  const bool is_inside = at.x() > -0.5 && at.y() > -0.5 && at.x() < camera.width - 0.5 && at.y() < camera.height - 0.5;
  if (!is_inside) return {0, 0, -1, -1};
  const double x = std::clamp(at.x(), 0.0, camera.width - 1.0);
  const double y = std::clamp(at.y(), 0.0, camera.height - 1.0);
  const auto x0 = static_cast<std::int32_t>(x);
  const auto y0 = static_cast<std::int32_t>(y);
  return {x - x0, y - y0, x0, y0};
}

Places find_places(const CameraIntrinsics& camera, const Lens& lens) {
  const auto width = static_cast<std::size_t>(camera.width);
  Places places(width * static_cast<std::size_t>(camera.height));
  tbb::parallel_for(0, camera.height, [&](int y) {
    Place* row = places.data() + static_cast<std::size_t>(y) * width;
    for (int x = 0; x < camera.width; ++x) {
      row[x] = place_of(std::visit([&](const auto& bent) { return distort_pixel(x, y, camera, bent); }, lens), camera);
    }
  });
  return places;
}

/// The places of the last few cameras: a recording's frames come from one or two, and finding the places takes longer
/// than all else.
class KnownPlaces {
 public:
  [[nodiscard]] std::shared_ptr<const Places> of(const CameraIntrinsics& camera, const Lens& lens) {
    if (auto known = find(camera, lens)) return known;
    auto places = std::make_shared<const Places>(find_places(camera, lens));
    constexpr std::size_t kMostPixels = 2'500'000;  // 60 MB
    if (places->size() <= kMostPixels) keep({camera, lens, places});
    return places;
  }

 private:
  struct Known {
    CameraIntrinsics camera;
    Lens lens;
    std::shared_ptr<const Places> places;
  };

  [[nodiscard]] std::shared_ptr<const Places> find(const CameraIntrinsics& camera, const Lens& lens) {
    const std::lock_guard lock(mutex_);
    for (const Known& known : known_) {
      if (known.camera == camera && known.lens == lens) return known.places;
    }
    return nullptr;
  }

  void keep(Known known) {
    constexpr std::size_t kMost = 2;  // depth and colour
    const std::lock_guard lock(mutex_);
    known_.push_front(std::move(known));
    if (known_.size() > kMost) known_.pop_back();
  }

  std::mutex mutex_;
  std::deque<Known> known_;
};

template <typename T, typename Sample>
Image<T> resample(const Image<T>& image, CameraIntrinsics camera, const Lens& lens, Sample sample) {
  camera.width = image.width();
  camera.height = image.height();
  static KnownPlaces known;
  const std::shared_ptr<const Places> places = known.of(camera, lens);
  Image<T> straight(image.width(), image.height());
  tbb::parallel_for(0, image.height(), [&](int y) {
    const Place* row = places->data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width());
    for (int x = 0; x < image.width(); ++x) {
      if (row[x].x >= 0) straight.at(x, y) = sample(image, row[x]);
    }
  });
  return straight;
}

template <typename T>
T sample_nearest(const Image<T>& image, const Place& at) {
  return image.at(at.x + (at.right >= 0.5 ? 1 : 0), at.y + (at.below >= 0.5 ? 1 : 0));
}

Rgb8 sample_bilinear(const ColourImage& image, const Place& at) {
  const int x1 = std::min(at.x + 1, image.width() - 1);
  const int y1 = std::min(at.y + 1, image.height() - 1);
  const Rgb8 &a = image.at(at.x, at.y), &b = image.at(x1, at.y), &c = image.at(at.x, y1), &d = image.at(x1, y1);
  const auto blend = [&](std::uint8_t Rgb8::*channel) {
    const double top = a.*channel + at.right * (b.*channel - a.*channel);
    const double bottom = c.*channel + at.right * (d.*channel - c.*channel);
    return static_cast<std::uint8_t>(top + at.below * (bottom - top) + 0.5);
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
  return resample(depth_m, camera, distortion, sample_nearest<float>);
}

Image<std::uint8_t> undistort(const Image<std::uint8_t>& mask, const CameraIntrinsics& camera,
                              const RationalDistortion& distortion) {
  return resample(mask, camera, distortion, sample_nearest<std::uint8_t>);
}

ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera, const RationalDistortion& distortion) {
  return resample(colour, camera, distortion, sample_bilinear);
}

DepthImage undistort(const DepthImage& depth_m, const CameraIntrinsics& camera, const FisheyeDistortion& distortion) {
  return resample(depth_m, camera, distortion, sample_nearest<float>);
}

ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera, const FisheyeDistortion& distortion) {
  return resample(colour, camera, distortion, sample_bilinear);
}

}  // namespace scanknit
