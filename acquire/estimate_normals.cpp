// Normals of a depth picture: least-squares planes in inverse depth over a star of pixels.
//
// A plane is linear in inverse depth over the picture: 1/z = a u + b v + c. With u = fx X/Z + cx and v = fy Y/Z + cy
// that is 1 = (a fx) X + (b fy) Y + (a cx + b cy + c) Z: the bracketed numbers are the plane's normal, up to length.
// The fit is linear, exact for planes of any slope, and holds for negative fy as it stands.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "acquire/depth_filter.h"
#include "core/check.h"

namespace scanknit {
namespace {

constexpr int kRays = 8;   // directions of the star
constexpr int kSteps = 3;  // samples along each
constexpr int kMaxStride = 5;
constexpr int kFewestSamples = 6;  // of 25; three settle a plane, six tell it from noise

// Sum of du^2 over the star at stride 1: each step k has six rays that move by k along u.
constexpr double kStarMoment = 6.0 * (1 + 4 + 9);
// The angle (rad) that noise may tilt a normal by, one sigma: 0.06 rad is 3.4 degrees.
constexpr double kTilt = 0.06;

// A ray ends where the depth jumps: by more than noise and a surface at 76 degrees (slope 4) explain.
constexpr double kMaxSlope = 4.0;
constexpr double kMaxNoiseSigmas = 4.5;  // 3 sigma of a difference of two measurements

struct Direction {
  int du = 0;
  int dv = 0;
};
constexpr std::array<Direction, kRays> kStar = {{{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

// Which of a ray's samples count, one bit a step, and what they add to a fit at stride 1: their number, the sum of
// their steps k and the sum of k^2. Looked up, since a pixel has eight rays and a ray eight patterns.
struct RayMoments {
  float n = 0, k = 0, kk = 0;
};
constexpr std::array<RayMoments, 1 << kSteps> make_ray_moments() {
  std::array<RayMoments, 1 << kSteps> table{};
  for (std::size_t pattern = 0; pattern < table.size(); ++pattern) {
    for (int step = 1; step <= kSteps; ++step) {
      if ((pattern >> (step - 1) & 1) == 0) continue;
      table[pattern].n += 1;
      table[pattern].k += static_cast<float>(step);
      table[pattern].kk += static_cast<float>(step * step);
    }
  }
  return table;
}
constexpr auto kRayMoments = make_ray_moments();

// Sums of a linear fit d(du, dv) = d0 + a du + b dv, in steps of the stride. The centre counts as one sample, d = 0.
struct PlaneSums {
  float n = 1, u = 0, v = 0, uu = 0, uv = 0, vv = 0, d = 0, ud = 0, vd = 0;

  void add_ray(const Direction& direction, const RayMoments& moments, float sum_d, float sum_kd) {
    const auto du = static_cast<float>(direction.du);
    const auto dv = static_cast<float>(direction.dv);
    n += moments.n;
    u += du * moments.k;
    v += dv * moments.k;
    uu += du * du * moments.kk;
    uv += du * dv * moments.kk;
    vv += dv * dv * moments.kk;
    d += sum_d;
    ud += du * sum_kd;
    vd += dv * sum_kd;
  }
};

struct InversePlane {
  float a = 0, b = 0, d0 = 0;
  bool is_settled = false;
};

InversePlane solve(const PlaneSums& s) {
  InversePlane plane;
  if (s.n < static_cast<float>(kFewestSamples)) return plane;
  const float mean_u = s.u / s.n;
  const float mean_v = s.v / s.n;
  const float mean_d = s.d / s.n;
  const float cuu = s.uu - s.u * mean_u;
  const float cuv = s.uv - s.u * mean_v;
  const float cvv = s.vv - s.v * mean_v;
  const float determinant = cuu * cvv - cuv * cuv;
  // Samples on a line settle no plane: their determinant is 0, that of a round star trace^2 / 4.
  const float trace = cuu + cvv;
  if (!(determinant > 0.02F * trace * trace)) return plane;
  const float cud = s.ud - s.u * mean_d;
  const float cvd = s.vd - s.v * mean_d;
  plane.a = (cvv * cud - cuv * cvd) / determinant;
  plane.b = (cuu * cvd - cuv * cud) / determinant;
  plane.d0 = mean_d - plane.a * mean_u - plane.b * mean_v;
  plane.is_settled = true;
  return plane;
}

// Inverse depth with a border of zeros as wide as the star reaches, so that no sample needs to be asked whether it is
// inside the picture.
class PaddedInverse {
 public:
  static constexpr int kBorder = kSteps * kMaxStride;

  explicit PaddedInverse(const DepthImage& depth_m)
      : image_(depth_m.width() + 2 * kBorder, depth_m.height() + 2 * kBorder) {
    for (int y = 0; y < depth_m.height(); ++y) {
      std::transform(depth_m.row(y).begin(), depth_m.row(y).end(), image_.row(y + kBorder).begin() + kBorder,
                     [](float z) { return z > 0 ? 1.0F / z : 0.0F; });
    }
  }
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y + kBorder) * static_cast<std::size_t>(image_.width()) +
           static_cast<std::size_t>(x + kBorder);
  }
  [[nodiscard]] std::ptrdiff_t offset(const Direction& direction, int stride) const {
    return (std::ptrdiff_t{direction.dv} * image_.width() + direction.du) * stride;
  }
  [[nodiscard]] float operator[](std::size_t i) const { return image_.pixels()[i]; }

 private:
  Image<float> image_;
};

// What does not change over the picture.
class NormalEstimator {
 public:
  NormalEstimator(const DepthImage& depth_m, const CameraIntrinsics& intrinsics, const NoiseModel& noise)
      : inverse_(depth_m),
        k_(intrinsics),
        noise_(noise),
        pitch_per_m_(1.0 / std::min(std::abs(intrinsics.fx), std::abs(intrinsics.fy))) {
    for (int stride = 1; stride <= kMaxStride; ++stride) {
      for (std::size_t ray = 0; ray < kStar.size(); ++ray) {
        offsets_[static_cast<std::size_t>(stride)][ray] = inverse_.offset(kStar[ray], stride);
      }
    }
  }

  [[nodiscard]] Eigen::Vector3f at(int x, int y) const {
    const std::size_t centre = inverse_.index(x, y);
    const double inverse_z = inverse_[centre];
    if (!(inverse_z > 0)) return Eigen::Vector3f::Zero();
    const double z = 1.0 / inverse_z;
    const double sigma_m = noise_.sigma_m(z);
    const double pitch_m = pitch_per_m_ * z;
    // sigma(slope) = sigma / (stride pitch sqrt(moment)) of a least-squares line.
    const double wanted = sigma_m / (pitch_m * kTilt * std::sqrt(kStarMoment));
    const int stride = std::clamp(static_cast<int>(std::ceil(std::min(wanted, double{kMaxStride}))), 1, kMaxStride);
    // A difference e of depths is about e / z^2 in inverse depth.
    const auto noise_jump = static_cast<float>(kMaxNoiseSigmas * sigma_m * inverse_z * inverse_z);
    const auto slope_jump = static_cast<float>(kMaxSlope * pitch_m * stride * inverse_z * inverse_z);

    const InversePlane plane = solve(gather(centre, stride, noise_jump, slope_jump));
    if (!plane.is_settled) return Eigen::Vector3f::Zero();
    const double a = double{plane.a} / stride;
    const double b = double{plane.b} / stride;
    const double d0 = inverse_z + double{plane.d0};
    const Eigen::Vector3d n(a * k_.fx, b * k_.fy, d0 + a * (k_.cx - x) + b * (k_.cy - y));
    const double length = n.norm();
    // n . p = 1 on the plane, so that -n looks at the camera.
    if (!(length > 0) || !(d0 > 0)) return Eigen::Vector3f::Zero();
    return (-n / length).cast<float>();
  }

 private:
  // Written with selections instead of branches: holes and edges are everywhere, and unpredictable.
  [[nodiscard]] PlaneSums gather(std::size_t centre, int stride, float noise_jump, float slope_jump) const {
    const float d_centre = inverse_[centre];
    PlaneSums sums;
    for (std::size_t ray = 0; ray < kStar.size(); ++ray) {
      const auto offset = static_cast<std::size_t>(offsets_[static_cast<std::size_t>(stride)][ray]);
      float last = d_centre;
      float allowed = noise_jump + slope_jump;
      float sum_d = 0;
      float sum_kd = 0;
      bool is_open = true;
      std::size_t pattern = 0;
      std::size_t i = centre;
      for (int step = 1; step <= kSteps; ++step) {
        i += offset;  // unsigned arithmetic wraps: the offset may be negative
        const float d = inverse_[i];
        const bool is_valid = d > 0;
        is_open = is_open && (!is_valid || std::abs(d - last) <= allowed);
        const bool counts = is_open && is_valid;
        const float difference = counts ? d - d_centre : 0.0F;
        sum_d += difference;
        sum_kd += static_cast<float>(step) * difference;
        pattern |= static_cast<std::size_t>(counts) << (step - 1);
        last = counts ? d : last;
        allowed = counts ? noise_jump + slope_jump : allowed + slope_jump;
      }
      sums.add_ray(kStar[ray], kRayMoments[pattern], sum_d, sum_kd);
    }
    return sums;
  }

  PaddedInverse inverse_;
  CameraIntrinsics k_;
  NoiseModel noise_;
  double pitch_per_m_;
  std::array<std::array<std::ptrdiff_t, kRays>, kMaxStride + 1> offsets_{};
};

}  // namespace

Image<Eigen::Vector3f> estimate_normals(const DepthImage& depth_m, const CameraIntrinsics& intrinsics,
                                        const NoiseModel& noise) {
  SCANKNIT_CHECK(intrinsics.is_valid());
  Image<Eigen::Vector3f> normals(depth_m.width(), depth_m.height(), Eigen::Vector3f::Zero());
  const NormalEstimator estimator(depth_m, intrinsics, noise);
  tbb::parallel_for(tbb::blocked_range<int>(0, depth_m.height()), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y != rows.end(); ++y) {
      for (int x = 0; x < depth_m.width(); ++x) normals.at(x, y) = estimator.at(x, y);
    }
  });
  return normals;
}

}  // namespace scanknit
