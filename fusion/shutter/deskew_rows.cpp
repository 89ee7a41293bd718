// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/shutter/deskew_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <array>

#include "core/pixels/pixel_vectors.inl"
#include "fusion/shutter/deskew_rows.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::RebindToSigned<Floats>;
using VI = hn::Vec<Ints>;

struct Vectors {
  VF x, y, z;
};

HWY_INLINE VF dot(const Vectors& a, const Vectors& b) {
  return hn::Add(hn::Mul(a.x, b.x), hn::Add(hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)));
}

/// Pixels as whole numbers; 0, 0 where not `is_inside`.
struct Places {
  VF x, y;
  MF is_inside;
};

HWY_INLINE VF ray_x(const RowFlow& flow, VF x) {
  return hn::Mul(hn::Sub(x, set(flow.cx)), set(flow.per_fx));
}
HWY_INLINE VF ray_y(const RowFlow& flow, VF y) {
  return hn::Mul(hn::Sub(y, set(flow.cy)), set(flow.per_fy));
}

HWY_INLINE VF whole(VF positive) {
  return hn::ConvertTo(Floats(), hn::ConvertTo(Ints(), positive));
}

/// Where the surfaces that pixels (x, y) show, at depth 1 / per_z, were seen. To first order, a point moves through the
/// picture in proportion to the time before or after the middle row (Longuet-Higgins & Prazdny 1980, "The
/// interpretation of a moving retinal image"), and the row that it reaches is the time: one linear equation.
HWY_INLINE Places find(const RowFlow& flow, VF x, VF y, VF per_z) {
  const VF rx = ray_x(flow, x), ry = ray_y(flow, y);
  const VF tx = set(flow.turn.x()), ty = set(flow.turn.y()), tz = set(flow.turn.z());
  const VF nearing = hn::Add(hn::Sub(hn::Mul(tx, ry), hn::Mul(ty, rx)), hn::Mul(set(flow.shift.z()), per_z));
  const VF across = hn::Sub(hn::Sub(hn::Mul(tz, ry), ty), hn::Mul(set(flow.shift.x()), per_z));
  const VF down = hn::Sub(hn::Sub(tx, hn::Mul(tz, rx)), hn::Mul(set(flow.shift.y()), per_z));
  const VF flow_u = hn::Mul(set(flow.fx), hn::Add(across, hn::Mul(rx, nearing)));
  const VF flow_v = hn::Mul(set(flow.fy), hn::Add(down, hn::Mul(ry, nearing)));
  const float height = static_cast<float>(flow.height);
  const VF per_height = set(1 / height);
  const VF half = set(0.5f);
  const VF first_v = hn::Add(y, hn::Mul(flow_v, set(0.5f * (1 / height) - 0.5f)));
  const VF v = hn::Add(hn::Div(first_v, hn::Sub(set(1), hn::Mul(flow_v, per_height))), half);
  const VF u = hn::Add(hn::Add(x, hn::Mul(flow_u, hn::Sub(hn::Mul(v, per_height), half))), half);
  const VF zero = hn::Zero(Floats());
  const MF is_right = hn::And(hn::Ge(u, zero), hn::Lt(u, set(static_cast<float>(flow.width))));
  const MF is_inside = hn::And(is_right, hn::And(hn::Ge(v, zero), hn::Lt(v, set(height))));
  return {whole(hn::IfThenElseZero(is_inside, u)), whole(hn::IfThenElseZero(is_inside, v)), is_inside};
}

HWY_INLINE VI number_of(const RowFlow& flow, const Places& places) {
  const Ints i;
  return hn::Add(hn::Mul(hn::ConvertTo(i, places.y), hn::Set(i, flow.width)), hn::ConvertTo(i, places.x));
}

HWY_INLINE Vectors gather_vectors(const float* numbers, VI at) {
  const Floats f;
  return {hn::GatherIndex(f, numbers, at), hn::GatherIndex(f, numbers + 1, at), hn::GatherIndex(f, numbers + 2, at)};
}

struct RowPoses {
  std::array<Vectors, 3> R;
  Vectors t;
};

/// The poses of the rows of the places. Mostly it is one row.
HWY_INLINE RowPoses poses_of(const RowPose* T_middle_row, const Places& places) {
  const Floats f;
  const Ints i;
  const float row = hn::GetLane(places.y);
  const float* numbers = T_middle_row->data();
  RowPoses poses;
  const auto fill = [&](const auto& number) {
    for (int k = 0; k < 3; ++k) poses.R[k] = {number(4 * k), number(4 * k + 1), number(4 * k + 2)};
    poses.t = {number(3), number(7), number(11)};
  };
  if (hn::AllTrue(f, hn::Eq(places.y, set(row)))) {
    numbers = T_middle_row[static_cast<int>(row)].data();
    fill([&](int k) { return set(numbers[k]); });
  } else {
    const VI first = hn::Mul(hn::ConvertTo(i, places.y), hn::Set(i, static_cast<int>(RowPose::SizeAtCompileTime)));
    fill([&](int k) { return hn::GatherIndex(f, numbers + k, first); });
  }
  return poses;
}

/// The depth of the pixels of `ray` on planes through p; that of p where a plane is seen too obliquely to tell.
HWY_INLINE VF depth_on_planes(const Vectors& ray, const Vectors& p, const Vectors& normal, float fx) {
  constexpr float kMostPixels = 4;  // of a plane that is seen at 45 degrees
  const VF z_m = hn::Div(dot(normal, p), dot(normal, ray));
  const VF most = hn::Div(hn::Mul(set(kMostPixels), p.z), hn::Abs(set(fx)));
  return hn::IfThenElse(hn::Lt(hn::Abs(hn::Sub(z_m, p.z)), most), z_m, p.z);
}

HWY_INLINE void deskew_group(const RowFlow& flow, const SeenSurface& seen, int first_x, int y, float* z_m,
                             Eigen::Vector3f* normals) {
  const Floats f;
  const Ints i;
  const VF zero = hn::Zero(f);
  const VF x = hn::Add(set(static_cast<float>(first_x)), lane_numbers());
  const VF row = set(static_cast<float>(y));
  const VF typical_m = set(seen.typical_m);
  const auto per_depth = [&](VF z) { return hn::Div(set(1), hn::IfThenElse(hn::Gt(z, zero), z, typical_m)); };
  const MF is_pixel = hn::Lt(x, set(static_cast<float>(flow.width)));

  const VI here = number_of(flow, {hn::IfThenElseZero(is_pixel, x), row, is_pixel});
  const VF per_z = per_depth(hn::GatherIndex(f, seen.z_m, here));
  Places places = find(flow, x, row, per_z);
  const VF per_z_there = per_depth(hn::GatherIndex(f, seen.z_m, number_of(flow, places)));
  const MF is_edge = hn::Gt(hn::Abs(hn::Sub(per_z_there, per_z)), set(seen.least_step));  // another surface, beside it
  const Places beside = find(flow, x, row, per_z_there);
  places.x = hn::IfThenElse(is_edge, beside.x, places.x);
  places.y = hn::IfThenElse(is_edge, beside.y, places.y);
  places.is_inside = hn::And(hn::And(is_pixel, places.is_inside), hn::Or(hn::Not(is_edge), beside.is_inside));

  const VI number = number_of(flow, places);
  const VF seen_z = hn::GatherIndex(f, seen.z_m, number);
  const Vectors point{hn::Mul(ray_x(flow, places.x), seen_z), hn::Mul(ray_y(flow, places.y), seen_z), seen_z};
  const RowPoses T_middle_row = poses_of(seen.T_middle_row, places);
  const Vectors p{hn::Add(dot(T_middle_row.R[0], point), T_middle_row.t.x),
                  hn::Add(dot(T_middle_row.R[1], point), T_middle_row.t.y),
                  hn::Add(dot(T_middle_row.R[2], point), T_middle_row.t.z)};
  const MF is_seen = hn::And(places.is_inside, hn::And(hn::Gt(seen_z, zero), hn::Gt(p.z, zero)));
  VF z = p.z;
  if (normals != nullptr) {
    const Vectors own = gather_vectors(seen.normals->data(), hn::Mul(number, hn::Set(i, 3)));
    const Vectors normal{dot(T_middle_row.R[0], own), dot(T_middle_row.R[1], own), dot(T_middle_row.R[2], own)};
    z = depth_on_planes({ray_x(flow, x), ray_y(flow, row), set(1)}, p, normal, flow.fx);
    hn::StoreInterleaved3(hn::IfThenElseZero(is_seen, normal.x), hn::IfThenElseZero(is_seen, normal.y),
                          hn::IfThenElseZero(is_seen, normal.z), f, normals[first_x].data());
  }
  hn::StoreU(hn::IfThenElseZero(is_seen, z), f, z_m + first_x);
}

void deskew_row(const RowFlow& flow, const SeenSurface& seen, int y, float* z_m, Eigen::Vector3f* normals) {
  for (int x = 0; x < flow.width; x += static_cast<int>(hn::Lanes(Floats()))) {
    deskew_group(flow, seen, x, y, z_m, normals);
  }
}

void find_places(const RowFlow& flow, float per_z, int y, std::int32_t* places) {
  const Ints i;
  for (int x = 0; x < flow.width; x += static_cast<int>(hn::Lanes(i))) {
    const VF column = hn::Add(set(static_cast<float>(x)), lane_numbers());
    const Places found = find(flow, column, set(static_cast<float>(y)), set(per_z));
    const auto is_inside = hn::RebindMask(i, found.is_inside);
    hn::StoreU(hn::IfThenElse(is_inside, number_of(flow, found), hn::Set(i, -1)), i, places + x);
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(deskew_row);
HWY_EXPORT(find_places);

RowFlow::RowFlow(const CameraIntrinsics& camera, const SteadyMotion& rows)
    : width(camera.width),
      height(camera.height),
      fx(static_cast<float>(camera.fx)),
      fy(static_cast<float>(camera.fy)),
      cx(static_cast<float>(camera.cx)),
      cy(static_cast<float>(camera.cy)),
      per_fx(1 / fx),
      per_fy(1 / fy),
      turn(rows.turn_rad.cast<float>()),
      shift(rows.shift_m.cast<float>()) {}

void deskew_row(const RowFlow& flow, const SeenSurface& seen, int y, float* z_m, Eigen::Vector3f* normals) {
  HWY_DYNAMIC_DISPATCH(deskew_row)(flow, seen, y, z_m, normals);
}

void find_places(const RowFlow& flow, float per_z, int y, std::int32_t* places) {
  HWY_DYNAMIC_DISPATCH(find_places)(flow, per_z, y, places);
}

}  // namespace scanknit
#endif
