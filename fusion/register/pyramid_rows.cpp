// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/register/pyramid_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <array>

#include "core/pixels/pixel_vectors.inl"
#include "fusion/register/pyramid_rows.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

struct Vectors {
  VF x, y, z;
};

HWY_INLINE VF dot(const Vectors& a, const Vectors& b) {
  return hn::Add(hn::Mul(a.x, b.x), hn::Add(hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)));
}
HWY_INLINE Vectors add_where(MF where, const Vectors& sum, const Vectors& v) {
  return {hn::Add(sum.x, hn::IfThenElseZero(where, v.x)), hn::Add(sum.y, hn::IfThenElseZero(where, v.y)),
          hn::Add(sum.z, hn::IfThenElseZero(where, v.z))};
}
HWY_INLINE Vectors where(MF where, const Vectors& yes, const Vectors& no) {
  return {hn::IfThenElse(where, yes.x, no.x), hn::IfThenElse(where, yes.y, no.y), hn::IfThenElse(where, yes.z, no.z)};
}

/// Rays through pixels first, first + every, ... of a row.
HWY_INLINE Vectors rays_from(const Rays& rays, int first, float every, int y) {
  const VF u = hn::Add(set(static_cast<float>(first)), hn::Mul(lane_numbers(), set(every)));
  return {hn::Mul(hn::Sub(u, set(rays.cx)), set(rays.per_fx)), set((static_cast<float>(y) - rays.cy) * rays.per_fy),
          set(1)};
}

/// Every other pixel of a finer row.
struct Samples {
  VF z_m;
  Vectors ray, normal;
  VF intensity;
};

HWY_INLINE void load_pair(const PlaneRow<const float>& row, const Rays& rays, int x, int y, Samples& even,
                          Samples& odd) {
  const Floats f;
  const auto load = [&](const float* numbers, VF& a, VF& b) { hn::LoadInterleaved2(f, numbers + 2 * x, a, b); };
  load(row.z_m, even.z_m, odd.z_m);
  load(row.nx, even.normal.x, odd.normal.x);
  load(row.ny, even.normal.y, odd.normal.y);
  load(row.nz, even.normal.z, odd.normal.z);
  even.intensity = odd.intensity = set(-1);
  if (row.intensity != nullptr) load(row.intensity, even.intensity, odd.intensity);
  even.ray = rays_from(rays, 2 * x, 2, y);
  odd.ray = rays_from(rays, 2 * x + 1, 2, y);
}

/// The mean planes of the samples on the nearest surfaces, where the coarse `ray` meets them.
HWY_INLINE void store_means(const std::array<Samples, 4>& samples, const Vectors& ray, const FloatNoise& noise, int x,
                            const PlaneRow<float>& coarse) {
  const Floats f;
  const VF zero = hn::Zero(f);
  VF nearest_z = zero;
  Vectors nearest_ray{zero, zero, zero}, nearest_normal{zero, zero, zero};
  for (const Samples& sample : samples) {
    const MF is_first = hn::Eq(nearest_z, zero);
    const MF is_nearer = hn::And(hn::Gt(sample.z_m, zero), hn::Or(is_first, hn::Lt(sample.z_m, nearest_z)));
    nearest_z = hn::IfThenElse(is_nearer, sample.z_m, nearest_z);
    nearest_ray = where(is_nearer, sample.ray, nearest_ray);
    nearest_normal = where(is_nearer, sample.normal, nearest_normal);
  }
  const MF is_seen = hn::Gt(nearest_z, zero);
  const Vectors p{hn::Mul(nearest_ray.x, nearest_z), hn::Mul(nearest_ray.y, nearest_z), nearest_z};
  const VF same = hn::Mul(set(kSameSurfaceSigmas), sigma_of(noise, nearest_z));
  Vectors normal{zero, zero, zero}, point{zero, zero, zero};
  VF points = zero, intensity = zero, intensities = zero;
  for (const Samples& sample : samples) {
    const Vectors q{hn::Mul(sample.ray.x, sample.z_m), hn::Mul(sample.ray.y, sample.z_m), sample.z_m};
    const VF off = hn::Abs(dot(nearest_normal, {hn::Sub(q.x, p.x), hn::Sub(q.y, p.y), hn::Sub(q.z, p.z)}));
    const MF is_same = hn::And(hn::Gt(sample.z_m, zero), hn::Le(off, same));
    normal = add_where(is_same, normal, sample.normal);
    point = add_where(is_same, point, q);
    points = hn::Add(points, hn::IfThenElseZero(is_same, set(1)));
    const MF is_bright = hn::And(is_same, hn::Ge(sample.intensity, zero));
    intensity = hn::Add(intensity, hn::IfThenElseZero(is_bright, sample.intensity));
    intensities = hn::Add(intensities, hn::IfThenElseZero(is_bright, set(1)));
  }
  const VF squared = dot(normal, normal);
  const VF length = hn::IfThenElse(hn::Gt(squared, zero), hn::Sqrt(squared), set(1));
  normal = {hn::Div(normal.x, length), hn::Div(normal.y, length), hn::Div(normal.z, length)};
  const VF slope = dot(normal, ray);
  const MF is_steep = hn::And(is_seen, hn::Lt(slope, set(-kMinSmoothedSlope)));
  const VF met = hn::Div(dot(normal, point), hn::IfThenElse(is_steep, hn::Mul(points, slope), set(1)));
  const VF z = hn::IfThenElse(hn::And(is_steep, hn::Gt(met, zero)), met, nearest_z);

  const auto put = [&](VF value, float* numbers) { hn::StoreU(value, f, numbers + x); };
  put(z, coarse.z_m);
  put(hn::IfThenElseZero(is_seen, normal.x), coarse.nx);
  put(hn::IfThenElseZero(is_seen, normal.y), coarse.ny);
  put(hn::IfThenElseZero(is_seen, normal.z), coarse.nz);
  const MF is_bright = hn::Gt(intensities, zero);
  put(hn::IfThenElse(is_bright, hn::Div(intensity, hn::IfThenElse(is_bright, intensities, set(1))), set(-1)),
      coarse.intensity);
}

void shrink_rows(const PlaneRow<const float>& upper, const PlaneRow<const float>& lower, const Rays& fine_rays,
                 const Rays& coarse_rays, const FloatNoise& noise, int width, int y, const PlaneRow<float>& coarse) {
  for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(Floats()))) {
    std::array<Samples, 4> samples;
    load_pair(upper, fine_rays, x, 2 * y, samples[0], samples[1]);
    load_pair(lower, fine_rays, x, 2 * y + 1, samples[2], samples[3]);
    store_means(samples, rays_from(coarse_rays, x, 1, y), noise, x, coarse);
  }
}

void split_normals(const Eigen::Vector3f* normals, const Rays& rays, int width, int y, float* nx, float* ny,
                   float* nz) {
  const Floats f;
  const VF zero = hn::Zero(f);
  for (int x = 0; x < width; x += static_cast<int>(hn::Lanes(f))) {
    Vectors normal{zero, zero, zero};
    if (normals != nullptr) hn::LoadInterleaved3(f, normals[x].data(), normal.x, normal.y, normal.z);
    const Vectors ray = rays_from(rays, x, 1, y);
    const VF away = hn::Sqrt(dot(ray, ray));
    const Vectors facing{hn::Neg(hn::Div(ray.x, away)), hn::Neg(hn::Div(ray.y, away)), hn::Neg(hn::Div(ray.z, away))};
    normal = where(hn::Gt(dot(normal, normal), zero), normal, facing);
    hn::StoreU(normal.x, f, nx + x);
    hn::StoreU(normal.y, f, ny + x);
    hn::StoreU(normal.z, f, nz + x);
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(shrink_rows);
HWY_EXPORT(split_normals);

void shrink_rows(const PlaneRow<const float>& upper, const PlaneRow<const float>& lower, const Rays& fine_rays,
                 const Rays& coarse_rays, const FloatNoise& noise, int width, int y, const PlaneRow<float>& coarse) {
  HWY_DYNAMIC_DISPATCH(shrink_rows)(upper, lower, fine_rays, coarse_rays, noise, width, y, coarse);
}

void split_normals(const Eigen::Vector3f* normals, const Rays& rays, int width, int y, float* nx, float* ny,
                   float* nz) {
  HWY_DYNAMIC_DISPATCH(split_normals)(normals, rays, width, y, nx, ny, nz);
}

}  // namespace scanknit
#endif
