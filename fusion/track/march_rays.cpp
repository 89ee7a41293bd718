// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/track/march_rays.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fusion/track/march_rays.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kPatchRays>;
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

// Columns and rows of a patch. Loaded: hn::Iota is a loop of stores on some targets.
alignas(64) constexpr RayLanes kColumns{0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
alignas(64) constexpr RayLanes kRows{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

void aim_patch(const Eye& eye, int x, int y, RayPatch& rays) {
  const Floats f;
  for (std::size_t lane = 0; lane < kPatchRays; lane += hn::Lanes(f)) {
    const VF u = hn::Add(set(static_cast<float>(x)), hn::Load(f, kColumns.data() + lane));
    const VF v = hn::Add(set(static_cast<float>(y)), hn::Load(f, kRows.data() + lane));
    const VF along_x = hn::Mul(hn::Sub(u, set(eye.cx)), set(eye.per_fx));
    const VF along_y = hn::Mul(hn::Sub(v, set(eye.cy)), set(eye.per_fy));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      constexpr float kLeast = 1e-6f;  // such a ray stays between its walls
      const float* row = eye.R.data() + 3 * axis;
      const VF step = hn::Add(hn::Add(hn::Mul(set(row[0]), along_x), hn::Mul(set(row[1]), along_y)), set(row[2]));
      const VF divisor = hn::IfThenElse(hn::Lt(hn::Abs(step), set(kLeast)), set(kLeast), step);
      hn::Store(step, f, rays.step[axis].data() + lane);
      hn::Store(hn::Div(set(1), divisor), f, rays.per_step[axis].data() + lane);
    }
    const VF squared = hn::Add(hn::Add(hn::Mul(along_x, along_x), hn::Mul(along_y, along_y)), set(1));
    hn::Store(hn::Div(set(eye.voxel_size_m), hn::Sqrt(squared)), f, rays.voxel_z_m.data() + lane);
    hn::Store(set(kNearestSurface_m), f, rays.at_z_m.data() + lane);
    for (RayLanes* none : {&rays.outside_z_m, &rays.outside_m, &rays.matter_z_m, &rays.matter_m}) {
      hn::Store(hn::Zero(f), f, none->data() + lane);
    }
  }
}

void aim_rays(const Eye& eye, int x, int y, RayTile& tile) {
  for (int down = 0; down < RayTile::kDown; ++down) {
    for (int across = 0; across < RayTile::kAcross; ++across) {
      aim_patch(eye, x + kPatchSide * across, y + kPatchSide * down, tile.patches[RayTile::number_of(across, down)]);
    }
  }
  tile.open.fill(kAllRays);
}

HWY_INLINE unsigned bits_of(MF mask) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(Floats(), mask, bytes.data());
  return bytes[0] | unsigned{bytes[1]} << 8;
}

/// Some neighbouring rays, as many as the processor takes at once, on their way through a block.
struct Walk {
  RayPatch* patch;
  std::size_t lane;
  VF z, far;
  VF outside, outside_m;  ///< as in RayPatch
  VF matter, matter_m;
  MF goes;  ///< on through the block
};

/// Takes rays through one block.
class Marcher {
 public:
  HWY_INLINE Marcher(const BlockField& block, float voxel_size_m)
      : block_(block), steps_per_m_(kCaution / voxel_size_m) {}

  /// False if none of the rays passes the block.
  HWY_INLINE bool begin(RayPatch& patch, std::size_t lane, Walk& walk) const {
    const Floats f;
    const VF at = hn::Load(f, patch.at_z_m.data() + lane);
    VF near = at;
    VF far = set(1e30f);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const VF per_step = hn::Load(f, patch.per_step[axis].data() + lane);
      const VF a = hn::Mul(set(-0.5f - block_.start[axis]), per_step);
      const VF b = hn::Mul(set(7.5f - block_.start[axis]), per_step);
      near = hn::Max(near, hn::Min(a, b));
      far = hn::Min(far, hn::Max(a, b));
    }
    const MF goes = hn::Lt(near, far);
    // Between the blocks that hold something lies what nobody knows.
    const VF voxel_z = hn::Load(f, patch.voxel_z_m.data() + lane);
    const MF is_new = hn::And(goes, hn::Gt(near, hn::Add(at, hn::Mul(set(kSameWall), voxel_z))));
    const VF was_outside = hn::Load(f, patch.outside_z_m.data() + lane);
    walk = {&patch,
            lane,
            hn::IfThenElse(goes, near, at),
            far,
            hn::IfThenZeroElse(is_new, was_outside),
            hn::Load(f, patch.outside_m.data() + lane),
            hn::Zero(f),
            hn::Zero(f),
            goes};
    return !hn::AllFalse(f, goes);
  }

  HWY_INLINE void step(Walk& walk) const {
    const Floats f;
    const VF value = hn::GatherIndex(f, block_.tsdf, sample_at(*walk.patch, walk.lane, walk.z));
    const MF known = hn::Eq(value, value);
    const MF is_matter = hn::And(walk.goes, hn::Le(value, hn::Zero(f)));
    walk.matter = hn::IfThenElse(is_matter, walk.z, walk.matter);
    walk.matter_m = hn::IfThenElse(is_matter, value, walk.matter_m);
    walk.goes = hn::AndNot(is_matter, walk.goes);
    walk.outside = hn::IfThenElse(walk.goes, hn::IfThenElseZero(known, walk.z), walk.outside);
    walk.outside_m = hn::IfThenElse(walk.goes, value, walk.outside_m);
    const VF step = hn::IfThenElse(known, hn::Max(hn::Mul(value, set(steps_per_m_)), set(kShortest)), set(1));
    const VF voxel_z = hn::Load(f, walk.patch->voxel_z_m.data() + walk.lane);
    walk.z = hn::IfThenElse(walk.goes, hn::Add(walk.z, hn::Mul(step, voxel_z)), walk.z);
    walk.goes = hn::And(walk.goes, hn::Lt(walk.z, walk.far));
  }

  /// Returns the rays that met matter, by bit.
  HWY_INLINE unsigned end(const Walk& walk) const {
    const Floats f;
    RayPatch& patch = *walk.patch;
    const MF is_over = hn::Gt(walk.matter, hn::Zero(f));
    const auto put = [&](VF value, RayLanes& all) { hn::Store(value, f, all.data() + walk.lane); };
    put(hn::IfThenElse(is_over, set(RayPatch::kOver), walk.z), patch.at_z_m);
    put(walk.outside, patch.outside_z_m);
    put(walk.outside_m, patch.outside_m);
    if (hn::AllFalse(f, is_over)) return 0;
    const auto keep = [&](VF now, RayLanes& all) {
      put(hn::IfThenElse(is_over, now, hn::Load(f, all.data() + walk.lane)), all);
    };
    keep(walk.matter, patch.matter_z_m);
    keep(walk.matter_m, patch.matter_m);
    return bits_of(is_over);
  }

 private:
  /// The nearest sample of the block, as OpenVDB counts them.
  HWY_INLINE VI sample_at(const RayPatch& patch, std::size_t lane, VF z) const {
    const Ints i;
    const auto along = [&](std::size_t axis) {
      const VF step = hn::Load(Floats(), patch.step[axis].data() + lane);
      const VF p = hn::Add(hn::Mul(z, step), set(block_.start[axis] + 0.5f));
      return hn::Min(hn::Max(hn::ConvertTo(i, p), hn::Zero(i)), hn::Set(i, 7));
    };
    return hn::Or(hn::Or(hn::ShiftLeft<6>(along(0)), hn::ShiftLeft<3>(along(1))), along(2));
  }

  const BlockField& block_;
  float steps_per_m_;
};

bool march_rays(const BlockField& block, float voxel_size_m, const PixelRect& pixels, RayTile& tile) {
  const Floats f;
  constexpr unsigned kLaneBits = (1u << hn::MaxLanes(Floats())) - 1;
  const Marcher marcher(block, voxel_size_m);
  std::array<Walk, RayTile::kAcross * RayTile::kDown * kPatchRays / hn::MaxLanes(Floats()) + 1> walks;
  std::size_t count = 0;
  for (int down = pixels.y0 / kPatchSide; down <= pixels.y1 / kPatchSide; ++down) {
    for (int across = pixels.x0 / kPatchSide; across <= pixels.x1 / kPatchSide; ++across) {
      const std::size_t number = RayTile::number_of(across, down);
      const unsigned open = tile.open[number] & rays_within(pixels, across, down);
      for (std::size_t lane = 0; lane < kPatchRays; lane += hn::Lanes(f)) {
        if ((open >> lane & kLaneBits) != 0) count += marcher.begin(tile.patches[number], lane, walks[count]) ? 1 : 0;
      }
    }
  }
  bool has_met = false;
  const auto end = [&](const Walk& walk) {
    const unsigned over = marcher.end(walk) << walk.lane;
    RayBits& open = tile.open[static_cast<std::size_t>(walk.patch - tile.patches.data())];
    open = static_cast<RayBits>(open & ~over);
    has_met = has_met || over != 0;
  };
  // Two at once: each step waits for the memory.
  std::size_t i = 0;
  for (; i + 1 < count; i += 2) {
    Walk a = walks[i], b = walks[i + 1];
    do {
      marcher.step(a);
      marcher.step(b);
    } while (!hn::AllFalse(f, hn::Or(a.goes, b.goes)));
    end(a);
    end(b);
  }
  if (i < count) {
    Walk a = walks[i];
    do marcher.step(a);
    while (!hn::AllFalse(f, a.goes));
    end(a);
  }
  return has_met;
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

void aim_rays(const Eye& eye, int x, int y, RayTile& tile) {
  HWY_DYNAMIC_DISPATCH(aim_rays)(eye, x, y, tile);
}

bool march_rays(const BlockField& block, float voxel_size_m, const PixelRect& pixels, RayTile& tile) {
  return HWY_DYNAMIC_DISPATCH(march_rays)(block, voxel_size_m, pixels, tile);
}

}  // namespace scanknit
#endif
