// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fusion/register/icp_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "fusion/register/icp_rows.h"

#ifndef SCANKNIT_FUSION_ICP_ROWS_SUMS
#define SCANKNIT_FUSION_ICP_ROWS_SUMS
namespace scanknit {

inline constexpr std::size_t kRowLanes = 8;
inline constexpr float kNearest_m = 0.01f;     // in front of the view: nearer points project anywhere
inline constexpr float kLeastSigma_m = 1e-5f;  // no depth camera is better, whatever the configuration says

/// Which of a row's sums stands where.
enum RowSum : std::size_t {
  kJtJ = 0,
  kJtr = 21,
  kInformation = 27,
  kWeights,
  kSquares,
  kContradictions,
  kColoured,
  kColourWeights,
  kColourOffset,
  kJtD,
  kDtD = kJtD + 6,
  kDtr,
  kPoints,
  kSeen,
  kInliers,
  kRowSums
};

/// A row's sums, each in eight parts: lane n holds pixels n, n + 8, n + 16 ...
struct alignas(32) RowLanes {
  float lanes[kRowSums][kRowLanes] = {};
};

}  // namespace scanknit
#endif

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Loaded: hn::Iota is a loop of stores on some targets.
alignas(32) constexpr std::array<float, kRowLanes> kLanes{0, 1, 2, 3, 4, 5, 6, 7};

using Floats = hn::CappedTag<float, kRowLanes>;
using Ints = hn::RebindToSigned<Floats>;
using VF = hn::Vec<Floats>;
using VI = hn::Vec<Ints>;
using MF = hn::Mask<Floats>;

struct V3 {
  VF x, y, z;
};

HWY_INLINE VF dot(const V3& a, const V3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE V3 cross(const V3& a, const V3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE V3 minus(const V3& a, const V3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 times(const V3& a, VF s) {
  return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)};
}

/// A vector, the same in all lanes.
struct Same3 {
  explicit Same3(const Eigen::Vector3d& v)
      : x(static_cast<float>(v.x())), y(static_cast<float>(v.y())), z(static_cast<float>(v.z())) {}
  [[nodiscard]] HWY_INLINE V3 all() const {
    const Floats f;
    return {hn::Set(f, x), hn::Set(f, y), hn::Set(f, z)};
  }
  float x, y, z;
};

/// A pose as floats.
class Mover {
 public:
  explicit Mover(const Pose& pose) : rows_{row(pose, 0), row(pose, 1), row(pose, 2)}, t_(pose.translation()) {}
  [[nodiscard]] HWY_INLINE V3 turn(const V3& v) const {
    return {dot(rows_[0].all(), v), dot(rows_[1].all(), v), dot(rows_[2].all(), v)};
  }
  [[nodiscard]] HWY_INLINE V3 move(const V3& v) const {
    const V3 turned = turn(v);
    const V3 t = t_.all();
    return {hn::Add(turned.x, t.x), hn::Add(turned.y, t.y), hn::Add(turned.z, t.z)};
  }

 private:
  static Same3 row(const Pose& pose, int i) { return Same3(pose.linear().row(i).transpose()); }

  Same3 rows_[3];
  Same3 t_;
};

/// Points of the frame in the view, and the pixels that they are at.
struct Projected {
  V3 p;
  VF per_z, u, v;
  VI pixel;
  VF u_pixel, v_pixel;
  MF is_in_view;
};

/// Everything of a registration as floats.
class RowSummer {
 public:
  /// `T_model_colour`: of the row when its colour was taken.
  RowSummer(const Registration& g, const Pose& T_model_row, const Pose& T_model_colour)
      : frame_(*g.frame),
        model_(*g.model),
        gate_(g.gate),
        noise_(g.noise),
        T_(T_model_row),
        centre_(g.centre),
        per_scale_(static_cast<float>(1 / g.scale_m)),
        moves_colour_(!g.colour_motion.is_still()),
        T_colour_(T_model_colour),
        colour_at_(T_model_colour.translation()),
        colour_turn_(T_model_colour.linear() * g.colour_motion.turn_rad),
        colour_shift_(T_model_colour.linear() * g.colour_motion.shift_m) {}

  void add_row(int y, RowLanes& sums) const {
    const Floats f;
    for (std::size_t first = 0; first < static_cast<std::size_t>(frame_.stride); first += kRowLanes) {
      for (std::size_t lane = 0; lane < kRowLanes; lane += hn::Lanes(f)) add(first + lane, y, lane, sums);
    }
  }

 private:
  HWY_INLINE void add(std::size_t x, int y, std::size_t lane, RowLanes& sums) const {
    const Floats f;
    const auto set = [&](float value) { return hn::Set(f, value); };
    const auto load = [&](const std::vector<float>& plane, std::size_t at) { return hn::LoadU(f, plane.data() + at); };
    const auto zero = hn::Zero(f);
    const auto one = set(1);
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(frame_.stride) + x;

    const VF z = load(frame_.z_m, at);
    const MF is_point = hn::Gt(z, zero);
    if (hn::AllFalse(f, is_point)) return;
    count(is_point, kPoints, lane, sums);

    const V3 point = frame_point(x, y, z);
    const Projected seen = project(T_.move(point), is_point);
    if (hn::AllFalse(f, seen.is_in_view)) return;
    const V3& p = seen.p;
    const VF model_z = hn::GatherIndex(f, model_.z_m.data(), seen.pixel);
    const MF is_seen = hn::And(seen.is_in_view, hn::Gt(model_z, zero));
    if (hn::AllFalse(f, is_seen)) return;
    count(is_seen, kSeen, lane, sums);

    const VF beyond = hn::Sub(z, set(static_cast<float>(noise_.from_m)));
    const VF sigma = hn::Add(set(static_cast<float>(noise_.floor_m)),
                             hn::Mul(set(static_cast<float>(noise_.growth_per_m)), hn::Mul(beyond, beyond)));
    const VF per_sigma = hn::Div(one, hn::Max(sigma, set(kLeastSigma_m)));
    const VF differing = hn::Abs(hn::Sub(p.z, model_z));
    const VF same = hn::Add(set(gate_.contradiction_m), hn::Mul(set(gate_.contradiction_sigmas), sigma));
    count(hn::And(is_seen, hn::Gt(differing, same)), kContradictions, lane, sums);

    // The plane that the view shows at that pixel.
    const CameraIntrinsics& m = model_.intrinsics;
    const V3 q = {
        hn::Mul(hn::Mul(hn::Sub(seen.u_pixel, set(static_cast<float>(m.cx))), set(static_cast<float>(1 / m.fx))),
                model_z),
        hn::Mul(hn::Mul(hn::Sub(seen.v_pixel, set(static_cast<float>(m.cy))), set(static_cast<float>(1 / m.fy))),
                model_z),
        model_z};
    const V3 n = {hn::GatherIndex(f, model_.nx.data(), seen.pixel), hn::GatherIndex(f, model_.ny.data(), seen.pixel),
                  hn::GatherIndex(f, model_.nz.data(), seen.pixel)};
    const V3 apart = minus(p, q);
    const VF reach = hn::Add(set(gate_.distance_m), hn::Mul(set(gate_.distance_per_m), z));
    const V3 frame_n = T_.turn({load(frame_.nx, at), load(frame_.ny, at), load(frame_.nz, at)});
    const MF is_near = hn::Lt(dot(apart, apart), hn::Mul(reach, reach));
    const MF is_alike = hn::Gt(dot(frame_n, n), set(gate_.min_cosine));
    const MF is_pair = hn::And(is_seen, hn::And(is_near, is_alike));
    if (hn::AllFalse(f, is_pair)) return;

    const VF residual = hn::Mul(dot(n, apart), per_sigma);
    count(hn::And(is_pair, hn::Lt(hn::Abs(residual), set(gate_.inlier_sigmas))), kInliers, lane, sums);
    const VF weight = hn::IfThenElseZero(is_pair, tukey(residual));

    const V3 a = times(n, per_sigma);
    accumulate(a, cross(arm_of(p), a), residual, weight, lane, sums);
    add_to(kInformation, hn::Mul(weight, hn::Mul(per_sigma, per_sigma)), lane, sums);
    add_to(kWeights, weight, lane, sums);
    add_to(kSquares, hn::Mul(weight, hn::Mul(residual, residual)), lane, sums);
    if (!(gate_.intensity_sigma > 0)) return;
    if (!moves_colour_) {
      add_colour(seen, is_pair, at, lane, sums);
      return;
    }
    const Projected moved = project(T_colour_.move(point), is_pair);
    const VF there_z = hn::GatherIndex(f, model_.z_m.data(), moved.pixel);
    const MF is_same = hn::Lt(hn::Abs(hn::Sub(moved.p.z, there_z)), reach);  // surface
    add_colour(moved, hn::And(moved.is_in_view, is_same), at, lane, sums);
  }

  HWY_INLINE void add_colour(const Projected& seen, MF is_pair, std::size_t at, std::size_t lane,
                             RowLanes& sums) const {
    const Floats f;
    const VF zero = hn::Zero(f);
    const VF ours = hn::LoadU(f, frame_.intensity.data() + at);
    const VF theirs = hn::GatherIndex(f, model_.intensity.data(), seen.pixel);
    const VF gx = hn::GatherIndex(f, model_.gx.data(), seen.pixel);
    const VF gy = hn::GatherIndex(f, model_.gy.data(), seen.pixel);
    const MF has_gradient = hn::Gt(hn::Add(hn::Abs(gx), hn::Abs(gy)), zero);
    const MF is_coloured = hn::And(hn::And(is_pair, has_gradient), hn::And(hn::Ge(ours, zero), hn::Ge(theirs, zero)));
    if (hn::AllFalse(f, is_coloured)) return;
    count(is_coloured, kColoured, lane, sums);
    const VF du = hn::IfThenElseZero(is_pair, hn::Sub(seen.u, seen.u_pixel));
    const VF dv = hn::IfThenElseZero(is_pair, hn::Sub(seen.v, seen.v_pixel));
    const VF there = hn::Add(theirs, hn::Add(hn::Mul(gx, du), hn::Mul(gy, dv)));
    const VF offset = hn::Sub(there, ours);
    const VF per_sigma = hn::Set(f, 1 / gate_.intensity_sigma);
    const VF residual = hn::Mul(hn::Add(offset, hn::Set(f, gate_.intensity_offset)), per_sigma);
    const VF weight = hn::IfThenElseZero(is_coloured, tukey(residual));
    // The derivative of the projection.
    const V3& p = seen.p;
    const VF along_x = hn::Mul(hn::Mul(gx, hn::Set(f, static_cast<float>(model_.intrinsics.fx))), seen.per_z);
    const VF along_y = hn::Mul(hn::Mul(gy, hn::Set(f, static_cast<float>(model_.intrinsics.fy))), seen.per_z);
    const VF along_z = hn::Neg(hn::Mul(hn::Add(hn::Mul(along_x, p.x), hn::Mul(along_y, p.y)), seen.per_z));
    const V3 a = times({along_x, along_y, along_z}, per_sigma);
    const V3 b = cross(arm_of(p), a);
    add_to(kColourWeights, weight, lane, sums);
    add_to(kColourOffset, hn::Neg(hn::Mul(weight, offset)), lane, sums);
    const VF counted = hn::Mul(weight, hn::Set(f, gate_.colour_weight));
    accumulate(a, b, residual, counted, lane, sums);
    if (moves_colour_) accumulate_time(a, b, p, residual, counted, lane, sums);
  }

  /// The pixels' points, in the frame's camera.
  HWY_INLINE V3 frame_point(std::size_t x, int y, VF z) const {
    const Floats f;
    const auto set = [&](float value) { return hn::Set(f, value); };
    const CameraIntrinsics& k = frame_.intrinsics;
    const VF ray_x = hn::Mul(
        hn::Sub(hn::Add(set(static_cast<float>(x)), hn::LoadU(f, kLanes.data())), set(static_cast<float>(k.cx))),
        set(static_cast<float>(1 / k.fx)));
    const VF ray_y = set((static_cast<float>(y) - static_cast<float>(k.cy)) * static_cast<float>(1 / k.fy));
    return {hn::Mul(ray_x, z), hn::Mul(ray_y, z), z};
  }

  HWY_INLINE Projected project(const V3& p, MF is_point) const {
    const Floats f;
    const Ints i;
    const auto set = [&](float value) { return hn::Set(f, value); };
    const VF zero = hn::Zero(f);
    const CameraIntrinsics& m = model_.intrinsics;
    const MF in_front = hn::And(is_point, hn::Gt(p.z, set(kNearest_m)));
    const VF per_z = hn::IfThenElseZero(in_front, hn::Div(set(1), p.z));
    const VF half = set(0.5f);
    const VF u = hn::Add(hn::Mul(hn::Mul(set(static_cast<float>(m.fx)), p.x), per_z), set(static_cast<float>(m.cx)));
    const VF v = hn::Add(hn::Mul(hn::Mul(set(static_cast<float>(m.fy)), p.y), per_z), set(static_cast<float>(m.cy)));
    const VF up = hn::Add(u, half);
    const VF vp = hn::Add(v, half);
    const MF in_u = hn::And(hn::Ge(up, zero), hn::Lt(up, set(static_cast<float>(m.width))));
    const MF in_v = hn::And(hn::Ge(vp, zero), hn::Lt(vp, set(static_cast<float>(m.height))));
    const MF in_view = hn::And(in_front, hn::And(in_u, in_v));
    const VI pixel_x = hn::ConvertTo(i, hn::IfThenElseZero(in_view, up));
    const VI pixel_y = hn::ConvertTo(i, hn::IfThenElseZero(in_view, vp));
    const VI pixel = hn::Add(hn::Mul(pixel_y, hn::Set(i, model_.stride)), pixel_x);
    return {p, per_z, u, v, pixel, hn::ConvertTo(f, pixel_x), hn::ConvertTo(f, pixel_y), in_view};
  }

  HWY_INLINE V3 arm_of(const V3& p) const { return times(minus(p, centre_.all()), hn::Set(Floats(), per_scale_)); }

  /// (1 - (r/c)^2)^2 within c, else 0.
  HWY_INLINE VF tukey(VF residual) const {
    const Floats f;
    const VF share = hn::Mul(residual, hn::Set(f, 1 / gate_.tukey_sigmas));
    const VF rest = hn::Max(hn::Zero(f), hn::Sub(hn::Set(f, 1), hn::Mul(share, share)));
    return hn::Mul(rest, rest);
  }

  static HWY_INLINE void add_to(std::size_t which, VF value, std::size_t lane, RowLanes& sums) {
    const Floats f;
    float* const sum = sums.lanes[which] + lane;
    hn::Store(hn::Add(hn::Load(f, sum), value), f, sum);
  }
  static HWY_INLINE void count(MF mask, std::size_t which, std::size_t lane, RowLanes& sums) {
    const Floats f;
    add_to(which, hn::IfThenElseZero(mask, hn::Set(f, 1)), lane, sums);
  }
  static HWY_INLINE void accumulate(const V3& a, const V3& b, VF residual, VF weight, std::size_t lane,
                                    RowLanes& sums) {
    const VF* const J[6] = {&a.x, &a.y, &a.z, &b.x, &b.y, &b.z};
    std::size_t entry = kJtJ;
    for (std::size_t row = 0; row < 6; ++row) {
      const VF weighted = hn::Mul(weight, *J[row]);
      for (std::size_t column = row; column < 6; ++column) add_to(entry++, hn::Mul(weighted, *J[column]), lane, sums);
      add_to(kJtr + row, hn::Mul(weighted, residual), lane, sums);
    }
  }

  /// Of a residual by Registration::colour_later: the points move as the camera does.
  HWY_INLINE void accumulate_time(const V3& a, const V3& b, const V3& p, VF residual, VF weight, std::size_t lane,
                                  RowLanes& sums) const {
    const V3 shift = colour_shift_.all();
    const V3 turned = cross(colour_turn_.all(), minus(p, colour_at_.all()));
    const VF D = dot(a, {hn::Add(shift.x, turned.x), hn::Add(shift.y, turned.y), hn::Add(shift.z, turned.z)});
    const VF weighted = hn::Mul(weight, D);
    const VF* const J[6] = {&a.x, &a.y, &a.z, &b.x, &b.y, &b.z};
    for (std::size_t row = 0; row < 6; ++row) add_to(kJtD + row, hn::Mul(weighted, *J[row]), lane, sums);
    add_to(kDtD, hn::Mul(weighted, D), lane, sums);
    add_to(kDtr, hn::Mul(weighted, residual), lane, sums);
  }

  const SurfaceLevel& frame_;
  const SurfaceLevel& model_;
  const PairGate& gate_;
  const NoiseModel& noise_;
  Mover T_;  ///< of the frame's camera in the view
  Same3 centre_;
  float per_scale_;
  bool moves_colour_;
  Mover T_colour_;                                ///< the same when colour was taken
  Same3 colour_at_, colour_turn_, colour_shift_;  ///< and its place and motion then, in the view's axes
};

void sum_row_lanes(const Registration& registration, int y, RowLanes& sums) {
  const Pose& T_model_frame = registration.T_model_frame;
  const SteadyMotion& rows = registration.rows;
  const int height = registration.frame->intrinsics.height;
  const Pose T_model_row = rows.is_still() ? T_model_frame : T_model_frame * pose_of_row(rows, y, height);
  const SteadyMotion& to_colour = registration.colour_motion;
  const Pose T_model_colour =
      to_colour.is_still() ? T_model_row : T_model_row * to_colour.after(registration.colour_later);
  RowSummer(registration, T_model_row, T_model_colour).add_row(y, sums);
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(sum_row_lanes);

PairSums sum_row(const Registration& registration, int y) {
  RowLanes row;
  HWY_DYNAMIC_DISPATCH(sum_row_lanes)(registration, y, row);
  const auto total = [&](std::size_t which) {
    double sum = 0;
    for (const float lane : row.lanes[which]) sum += static_cast<double>(lane);
    return sum;
  };
  PairSums sums;
  for (std::size_t i = 0; i < sums.JtJ.size(); ++i) sums.JtJ[i] = total(kJtJ + i);
  for (std::size_t i = 0; i < sums.Jtr.size(); ++i) sums.Jtr[i] = total(kJtr + i);
  for (std::size_t i = 0; i < sums.JtD.size(); ++i) sums.JtD[i] = total(kJtD + i);
  sums.DtD = total(kDtD);
  sums.Dtr = total(kDtr);
  sums.information = total(kInformation);
  sums.weights = total(kWeights);
  sums.squares = total(kSquares);
  sums.contradictions = total(kContradictions);
  sums.coloured = total(kColoured);
  sums.colour_weights = total(kColourWeights);
  sums.colour_offset = total(kColourOffset);
  sums.points = total(kPoints);
  sums.seen = total(kSeen);
  sums.inliers = total(kInliers);
  return sums;
}

PairSums& PairSums::operator+=(const PairSums& other) {
  for (std::size_t i = 0; i < JtJ.size(); ++i) JtJ[i] += other.JtJ[i];
  for (std::size_t i = 0; i < Jtr.size(); ++i) Jtr[i] += other.Jtr[i];
  for (std::size_t i = 0; i < JtD.size(); ++i) JtD[i] += other.JtD[i];
  DtD += other.DtD;
  Dtr += other.Dtr;
  information += other.information;
  weights += other.weights;
  squares += other.squares;
  contradictions += other.contradictions;
  coloured += other.coloured;
  colour_weights += other.colour_weights;
  colour_offset += other.colour_offset;
  points += other.points;
  seen += other.seen;
  inliers += other.inliers;
  return *this;
}

}  // namespace scanknit
#endif
