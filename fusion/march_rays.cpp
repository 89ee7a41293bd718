// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/march_rays.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fusion/march_rays.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kPixelGroup>;
using Ints = hn::RebindToSigned<Floats>;
using VF = hn::Vec<Floats>;
using VI = hn::Vec<Ints>;
using MF = hn::Mask<Floats>;

constexpr float kCaution = 0.8f;    // of the distance to the surface is stepped: it was measured from another side
constexpr float kShortest = 0.5f;   // step in free space, voxels
constexpr float kSameWall = 0.01f;  // voxels: where one block ends and the next begins, but for rounding

HWY_INLINE VF set(float value) {
  return hn::Set(Floats(), value);
}

// Loaded: hn::Iota is a loop of stores on some targets.
alignas(32) constexpr std::array<float, kPixelGroup> kLanes{0, 1, 2, 3, 4, 5, 6, 7};

void aim_rays(const Eye& eye, int x, int y, RayGroup& rays) {
  const Floats f;
  const VF along_y = hn::Mul(hn::Sub(set(static_cast<float>(y)), set(eye.cy)), set(eye.per_fy));
  for (std::size_t lane = 0; lane < kPixelGroup; lane += hn::Lanes(f)) {
    const VF u = hn::Add(set(static_cast<float>(x)), hn::LoadU(f, kLanes.data() + lane));
    const VF along_x = hn::Mul(hn::Sub(u, set(eye.cx)), set(eye.per_fx));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      constexpr float kLeast = 1e-6f;  // such a ray stays between its walls
      const float* row = eye.R.data() + 3 * axis;
      const VF step = hn::Add(hn::Add(hn::Mul(set(row[0]), along_x), hn::Mul(set(row[1]), along_y)), set(row[2]));
      const VF divisor = hn::IfThenElse(hn::Lt(hn::Abs(step), set(kLeast)), set(kLeast), step);
      hn::StoreU(step, f, rays.step[axis].data() + lane);
      hn::StoreU(hn::Div(set(1), divisor), f, rays.per_step[axis].data() + lane);
    }
    const VF squared = hn::Add(hn::Add(hn::Mul(along_x, along_x), hn::Mul(along_y, along_y)), set(1));
    hn::StoreU(hn::Div(set(eye.voxel_size_m), hn::Sqrt(squared)), f, rays.voxel_z_m.data() + lane);
    hn::StoreU(set(kNearestSurface_m), f, rays.at_z_m.data() + lane);
    for (PixelLanes* none : {&rays.outside_z_m, &rays.outside_m, &rays.matter_z_m, &rays.matter_m}) {
      hn::StoreU(hn::Zero(f), f, none->data() + lane);
    }
  }
}

/// Some neighbouring rays, as many as the processor takes at once.
class Marcher {
 public:
  HWY_INLINE Marcher(const BlockField& block, float voxel_size_m)
      : block_(block), steps_per_m_(kCaution / voxel_size_m) {}

  HWY_INLINE void march(RayGroup& group, std::size_t lane) const {
    const Floats f;
    const VF at = hn::LoadU(f, group.at_z_m.data() + lane);
    VF near = at;
    VF far = set(1e30f);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const VF per_step = hn::LoadU(f, group.per_step[axis].data() + lane);
      const VF a = hn::Mul(set(-0.5f - block_.start[axis]), per_step);
      const VF b = hn::Mul(set(7.5f - block_.start[axis]), per_step);
      near = hn::Max(near, hn::Min(a, b));
      far = hn::Min(far, hn::Max(a, b));
    }
    MF goes = hn::Lt(near, far);
    if (hn::AllFalse(f, goes)) return;

    const MF takes_part = goes;
    const VF voxel_z = hn::LoadU(f, group.voxel_z_m.data() + lane);
    const VF zero = hn::Zero(f);
    // Between the blocks that hold something lies what nobody knows.
    const MF goes_on = hn::Le(near, hn::Add(at, hn::Mul(set(kSameWall), voxel_z)));
    const VF was_outside = hn::LoadU(f, group.outside_z_m.data() + lane);
    VF outside = hn::IfThenElseZero(goes_on, was_outside);
    VF outside_m = hn::LoadU(f, group.outside_m.data() + lane);
    VF matter = zero;
    VF matter_m = zero;
    VF z = near;
    do {
      const VI sample = sample_at(group, lane, z);
      const VF value = hn::GatherIndex(f, block_.tsdf, sample);
      const MF known = is_observed(sample);
      const MF is_matter = hn::And(hn::And(goes, known), hn::Le(value, zero));
      matter = hn::IfThenElse(is_matter, z, matter);
      matter_m = hn::IfThenElse(is_matter, value, matter_m);
      goes = hn::AndNot(is_matter, goes);
      outside = hn::IfThenElse(goes, hn::IfThenElseZero(known, z), outside);
      outside_m = hn::IfThenElse(goes, value, outside_m);
      const VF step = hn::IfThenElse(known, hn::Max(hn::Mul(value, set(steps_per_m_)), set(kShortest)), set(1));
      z = hn::IfThenElse(goes, hn::Add(z, hn::Mul(step, voxel_z)), z);
      goes = hn::And(goes, hn::Lt(z, far));
    } while (!hn::AllFalse(f, goes));

    const MF is_over = hn::Gt(matter, zero);
    const VF now_at = hn::IfThenElse(is_over, set(RayGroup::kOver), z);
    hn::StoreU(hn::IfThenElse(takes_part, now_at, at), f, group.at_z_m.data() + lane);
    hn::StoreU(hn::IfThenElse(takes_part, outside, was_outside), f, group.outside_z_m.data() + lane);
    hn::StoreU(outside_m, f, group.outside_m.data() + lane);
    if (hn::AllFalse(f, is_over)) return;
    const auto keep = [&](VF now, PixelLanes& all) {
      hn::StoreU(hn::IfThenElse(is_over, now, hn::LoadU(f, all.data() + lane)), f, all.data() + lane);
    };
    keep(matter, group.matter_z_m);
    keep(matter_m, group.matter_m);
  }

 private:
  /// The nearest sample of the block, as OpenVDB counts them.
  HWY_INLINE VI sample_at(const RayGroup& group, std::size_t lane, VF z) const {
    const Ints i;
    const auto along = [&](std::size_t axis) {
      const VF step = hn::LoadU(Floats(), group.step[axis].data() + lane);
      const VF p = hn::Add(hn::Mul(z, step), set(block_.start[axis] + 0.5f));
      return hn::Min(hn::Max(hn::ConvertTo(i, p), hn::Zero(i)), hn::Set(i, 7));
    };
    return hn::Or(hn::Or(hn::ShiftLeft<6>(along(0)), hn::ShiftLeft<3>(along(1))), along(2));
  }

  HWY_INLINE MF is_observed(VI sample) const {
    const Ints i;
    const auto* const words = reinterpret_cast<const std::int32_t*>(block_.observed.data());
    const VI word = hn::GatherIndex(i, words, hn::ShiftRight<5>(sample));
    const VI bit = hn::Shl(hn::Set(i, 1), hn::And(sample, hn::Set(i, 31)));
    return hn::RebindMask(Floats(), hn::TestBit(word, bit));
  }

  const BlockField& block_;
  float steps_per_m_;
};

void march_rays(const BlockField& block, float voxel_size_m, RayGroup* groups, int count) {
  const Marcher marcher(block, voxel_size_m);
  for (int g = 0; g < count; ++g) {
    for (std::size_t lane = 0; lane < kPixelGroup; lane += hn::Lanes(Floats())) marcher.march(groups[g], lane);
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(aim_rays);
HWY_EXPORT(march_rays);

Eye::Eye(const CameraIntrinsics& k, const Pose& T_world_camera, double size_m)
    : per_fx(static_cast<float>(1 / k.fx)),
      per_fy(static_cast<float>(1 / k.fy)),
      cx(static_cast<float>(k.cx)),
      cy(static_cast<float>(k.cy)),
      voxel_size_m(static_cast<float>(size_m)) {
  for (int row = 0; row < 3; ++row) {
    start[static_cast<std::size_t>(row)] = static_cast<float>(T_world_camera.translation()[row] / size_m);
    for (int column = 0; column < 3; ++column) {
      R[static_cast<std::size_t>(3 * row + column)] = static_cast<float>(T_world_camera.linear()(row, column) / size_m);
    }
  }
}

void aim_rays(const Eye& eye, int x, int y, RayGroup& rays) {
  HWY_DYNAMIC_DISPATCH(aim_rays)(eye, x, y, rays);
}

void march_rays(const BlockField& block, float voxel_size_m, RayGroup* groups, int count) {
  HWY_DYNAMIC_DISPATCH(march_rays)(block, voxel_size_m, groups, count);
}

}  // namespace scanknit
#endif
