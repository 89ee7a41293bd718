// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "acquire/filter/depth_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "acquire/filter/depth_rows.h"
#include "core/pixels/pixel_vectors.inl"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kSteps = 3;  // samples along each of the star's eight rays
constexpr int kMaxStride = 5;
constexpr float kFewestSamples = 6;  // of 25; three settle a plane, six tell it from noise

// Sum of du^2 over the star at stride 1: each step k has six rays that move by k along u.
constexpr float kStarMoment = 6.0F * (1 + 4 + 9);
// The angle (rad) that noise may tilt a normal by, one sigma: 0.06 rad is 3.4 degrees.
constexpr float kTilt = 0.06F;

// A ray ends where the depth jumps: by more than noise and a surface at 76 degrees (slope 4) explain.
constexpr float kMaxSlope = 4.0F;
constexpr float kMaxNoiseSigmas = 4.5F;  // 3 sigma of a difference of two measurements

HWY_INLINE VF one_where(MF mask) {
  return hn::IfThenElseZero(mask, set(1));
}

/// Sums of a linear fit d(du, dv) = d0 + a du + b dv, in steps of the stride. The centre counts as one sample, d = 0.
struct PlaneSums {
  VF n, u, v, uu, uv, vv, d, ud, vd;
};

HWY_INLINE PlaneSums sums_of_centre() {
  const VF zero = set(0);
  return {set(1), zero, zero, zero, zero, zero, zero, zero, zero};
}

/// The samples of one ray of the star, as far as the surface goes on. Without branches: holes and edges are everywhere,
/// and unpredictable.
template <int kDu, int kDv>
HWY_INLINE void add_ray(const float* centre, std::ptrdiff_t pitch, int stride, VF noise_jump, VF slope_jump,
                        PlaneSums& sums) {
  const Floats f;
  const VF zero = hn::Zero(f);
  const VF d_centre = hn::LoadU(f, centre);
  const std::ptrdiff_t step_offset = (kDv * pitch + kDu) * stride;
  const VF jump = hn::Add(noise_jump, slope_jump);
  VF last = d_centre;
  VF allowed = jump;
  VF n = zero, k = zero, kk = zero, sum_d = zero, sum_kd = zero;
  MF is_open = hn::Eq(zero, zero);
  for (int step = 1; step <= kSteps; ++step) {
    const VF d = hn::LoadU(f, centre + step * step_offset);
    const MF is_valid = hn::Gt(d, zero);
    is_open = hn::And(is_open, hn::Or(hn::Not(is_valid), hn::Le(hn::Abs(hn::Sub(d, last)), allowed)));
    const MF counts = hn::And(is_open, is_valid);
    const VF difference = hn::IfThenElseZero(counts, hn::Sub(d, d_centre));
    const auto k_here = static_cast<float>(step);
    sum_d = hn::Add(sum_d, difference);
    sum_kd = hn::Add(sum_kd, hn::Mul(set(k_here), difference));
    n = hn::Add(n, one_where(counts));
    k = hn::Add(k, hn::IfThenElseZero(counts, set(k_here)));
    kk = hn::Add(kk, hn::IfThenElseZero(counts, set(k_here * k_here)));
    last = hn::IfThenElse(counts, d, last);
    allowed = hn::IfThenElse(counts, jump, hn::Add(allowed, slope_jump));
  }
  const auto add = [](VF& sum, int times, VF value) {
    if (times == 1) sum = hn::Add(sum, value);
    if (times == -1) sum = hn::Sub(sum, value);
  };
  add(sums.n, 1, n);
  add(sums.u, kDu, k);
  add(sums.v, kDv, k);
  add(sums.uu, kDu * kDu, kk);
  add(sums.uv, kDu * kDv, kk);
  add(sums.vv, kDv * kDv, kk);
  add(sums.d, 1, sum_d);
  add(sums.ud, kDu, sum_kd);
  add(sums.vd, kDv, sum_kd);
}

/// Normals, not of unit length and away from the camera, of the pixels whose plane is settled; else zero.
struct Normals {
  VF x, y, z;
};

HWY_INLINE Normals solve(const NormalContext& context, const PlaneSums& s, VF inverse_z, int stride, int x, int y) {
  const Floats f;
  const VF mean_u = hn::Div(s.u, s.n);
  const VF mean_v = hn::Div(s.v, s.n);
  const VF mean_d = hn::Div(s.d, s.n);
  const VF cuu = hn::Sub(s.uu, hn::Mul(s.u, mean_u));
  const VF cuv = hn::Sub(s.uv, hn::Mul(s.u, mean_v));
  const VF cvv = hn::Sub(s.vv, hn::Mul(s.v, mean_v));
  const VF determinant = hn::Sub(hn::Mul(cuu, cvv), hn::Mul(cuv, cuv));
  // Samples on a line settle no plane: their determinant is 0, that of a round star trace^2 / 4.
  const VF trace = hn::Add(cuu, cvv);
  const VF cud = hn::Sub(s.ud, hn::Mul(s.u, mean_d));
  const VF cvd = hn::Sub(s.vd, hn::Mul(s.v, mean_d));
  const VF a = hn::Div(hn::Sub(hn::Mul(cvv, cud), hn::Mul(cuv, cvd)), determinant);
  const VF b = hn::Div(hn::Sub(hn::Mul(cuu, cvd), hn::Mul(cuv, cud)), determinant);
  const VF d0 = hn::Add(inverse_z, hn::Sub(hn::Sub(mean_d, hn::Mul(a, mean_u)), hn::Mul(b, mean_v)));
  const MF is_settled = hn::And(
      hn::And(hn::Ge(s.n, set(kFewestSamples)), hn::Gt(determinant, hn::Mul(set(0.02F), hn::Mul(trace, trace)))),
      hn::Gt(d0, hn::Zero(f)));

  // n . p = 1 on the plane.
  const VF per_stride = set(1 / static_cast<float>(stride));
  const VF along_u = hn::Mul(a, per_stride);
  const VF along_v = hn::Mul(b, per_stride);
  const VF from_centre = hn::Sub(set(context.cx - static_cast<float>(x)), lane_numbers());
  const VF nz =
      hn::Add(hn::Add(d0, hn::Mul(along_u, from_centre)), hn::Mul(along_v, set(context.cy - static_cast<float>(y))));
  return {hn::IfThenElseZero(is_settled, hn::Mul(along_u, set(context.fx))),
          hn::IfThenElseZero(is_settled, hn::Mul(along_v, set(context.fy))), hn::IfThenElseZero(is_settled, nz)};
}

HWY_INLINE Normals normals_with_stride(const NormalContext& context, const float* centre, std::ptrdiff_t pitch,
                                       int stride, int x, int y) {
  const VF inverse_z = hn::LoadU(Floats(), centre);
  const VF z = hn::Div(set(1), inverse_z);
  // A difference e of depths is about e / z^2 in inverse depth.
  const VF squared = hn::Mul(inverse_z, inverse_z);
  const VF noise_jump = hn::Mul(hn::Mul(set(kMaxNoiseSigmas), sigma_of(context.noise, z)), squared);
  const VF slope_jump = hn::Mul(set(kMaxSlope * context.pitch_per_m * static_cast<float>(stride)), hn::Mul(z, squared));
  PlaneSums sums = sums_of_centre();
  add_ray<1, 0>(centre, pitch, stride, noise_jump, slope_jump, sums);
  add_ray<1, 1>(centre, pitch, stride, noise_jump, slope_jump, sums);
  add_ray<0, 1>(centre, pitch, stride, noise_jump, slope_jump, sums);
  add_ray<-1, 1>(centre, pitch, stride, noise_jump, slope_jump, sums);
  add_ray<-1, 0>(centre, pitch, stride, noise_jump, slope_jump, sums);
  add_ray<-1, -1>(centre, pitch, stride, noise_jump, slope_jump, sums);
  add_ray<0, -1>(centre, pitch, stride, noise_jump, slope_jump, sums);
  add_ray<1, -1>(centre, pitch, stride, noise_jump, slope_jump, sums);
  return solve(context, sums, inverse_z, stride, x, y);
}

/// The stride at which noise tilts the plane of a whole star by no more than kTilt.
HWY_INLINE VF stride_of(const NormalContext& context, VF inverse_z) {
  const VF z = hn::Div(set(1), inverse_z);
  // sigma(slope) = sigma / (stride pitch sqrt(moment)) of a least-squares line.
  const VF per_pitch = set(1 / (context.pitch_per_m * kTilt * std::sqrt(kStarMoment)));
  const VF wanted = hn::Mul(hn::Mul(sigma_of(context.noise, z), inverse_z), per_pitch);
  return hn::Max(hn::Ceil(hn::Min(wanted, set(kMaxStride))), set(1));
}

void invert_row(const float* z_m, int width, float* inverse) {
  const Floats f;
  int x = 0;
  for (const auto lanes = static_cast<int>(hn::Lanes(f)); x + lanes <= width; x += lanes) {
    const VF z = hn::LoadU(f, z_m + x);
    hn::StoreU(hn::IfThenElseZero(hn::Gt(z, hn::Zero(f)), hn::Div(set(1), z)), f, inverse + x);
  }
  for (; x < width; ++x) inverse[x] = z_m[x] > 0 ? 1 / z_m[x] : 0;
}

void find_row_normals(const NormalContext& context, const float* inverse, std::ptrdiff_t pitch, int width, int y,
                      Eigen::Vector3f* normals) {
  const Floats f;
  for_each_group(0, width, [&](int x) {
    const float* centre = inverse + x;
    const VF inverse_z = hn::LoadU(f, centre);
    const MF has_return = hn::Gt(inverse_z, hn::Zero(f));
    const VF stride = hn::IfThenElseZero(has_return, stride_of(context, inverse_z));
    VF nx = hn::Zero(f), ny = hn::Zero(f), nz = hn::Zero(f);
    for (int each = 1; each <= kMaxStride; ++each) {
      const MF is_it = hn::Eq(stride, set(static_cast<float>(each)));
      if (hn::AllFalse(f, is_it)) continue;
      const Normals found = normals_with_stride(context, centre, pitch, each, x, y);
      nx = hn::IfThenElse(is_it, found.x, nx);
      ny = hn::IfThenElse(is_it, found.y, ny);
      nz = hn::IfThenElse(is_it, found.z, nz);
    }
    const VF squared = hn::Add(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)), hn::Mul(nz, nz));
    // -n looks at the camera.
    const VF scale = hn::IfThenElseZero(hn::Gt(squared, hn::Zero(f)), hn::Div(set(-1), hn::Sqrt(squared)));
    hn::StoreInterleaved3(hn::Mul(nx, scale), hn::Mul(ny, scale), hn::Mul(nz, scale), f, normals[x].data());
  });
}

GroupDeviation find_deviations(const FloatNoise& noise, const float* inverse, std::ptrdiff_t step, float sigmas) {
  const Floats f;
  GroupDeviation group;
  for (int lane = 0; lane < kPixelGroup; lane += static_cast<int>(hn::Lanes(f))) {
    const VF zero = hn::Zero(f);
    const VF own = hn::LoadU(f, inverse + lane);
    const VF before = hn::LoadU(f, inverse + lane - step);
    const VF after = hn::LoadU(f, inverse + lane + step);
    const MF has_return = hn::Gt(own, zero);
    const MF has_both = hn::And(hn::Gt(before, zero), hn::Gt(after, zero));
    const VF z = hn::Div(set(1), own);
    // A difference e of inverse depths is about e z^2 in metres; the middle of two has half of their variance.
    const VF off = hn::Abs(hn::Sub(own, hn::Mul(set(0.5F), hn::Add(before, after))));
    const VF limit = hn::Mul(set(sigmas * 1.2247449F), hn::Mul(sigma_of(noise, z), hn::Mul(own, own)));
    const MF deviates = hn::And(hn::And(has_return, has_both), hn::Gt(off, limit));
    group.deviates = static_cast<std::uint16_t>(group.deviates | bits(deviates) << lane);
    group.is_unsure = static_cast<std::uint16_t>(group.is_unsure | bits(hn::AndNot(has_both, has_return)) << lane);
  }
  return group;
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(invert_row);
HWY_EXPORT(find_row_normals);
HWY_EXPORT(find_deviations);

NormalContext::NormalContext(const CameraIntrinsics& k, const NoiseModel& depth_noise)
    : fx(static_cast<float>(k.fx)),
      fy(static_cast<float>(k.fy)),
      cx(static_cast<float>(k.cx)),
      cy(static_cast<float>(k.cy)),
      pitch_per_m(static_cast<float>(1 / std::min(std::abs(k.fx), std::abs(k.fy)))),
      noise(depth_noise) {}

void invert_row(std::span<const float> z_m, float* inverse) {
  HWY_DYNAMIC_DISPATCH(invert_row)(z_m.data(), static_cast<int>(z_m.size()), inverse);
}

void find_row_normals(const NormalContext& context, const float* inverse, std::ptrdiff_t pitch, int y,
                      std::span<Eigen::Vector3f> normals) {
  const auto width = static_cast<int>(normals.size());
  if (width >= kPixelGroup) {
    HWY_DYNAMIC_DISPATCH(find_row_normals)(context, inverse, pitch, width, y, normals.data());
    return;
  }
  std::array<Eigen::Vector3f, kPixelGroup> wide;
  HWY_DYNAMIC_DISPATCH(find_row_normals)(context, inverse, pitch, kPixelGroup, y, wide.data());
  std::copy_n(wide.begin(), width, normals.begin());
}

GroupDeviation find_deviations(const FloatNoise& noise, const float* inverse, std::ptrdiff_t step, float sigmas) {
  return HWY_DYNAMIC_DISPATCH(find_deviations)(noise, inverse, step, sigmas);
}

}  // namespace scanknit
#endif
