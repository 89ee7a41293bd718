// Compiled once for each instruction set by Highway, which includes this file again through foreach_target.h.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extract/blocks/crossing_points.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

#include "extract/blocks/crossing_points.h"

HWY_BEFORE_NAMESPACE();
namespace scanknit::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void crossing_points(const CrossingEdges& edges, const CrossingFrame& frame, std::span<Eigen::Vector3f> p_world) {
  const hn::CappedTag<double, 8> doubles;
  const hn::Rebind<float, decltype(doubles)> floats;
  const std::size_t lanes = hn::Lanes(doubles);
  const auto isovalue = hn::Set(doubles, frame.isovalue);
  const auto least = hn::Set(doubles, frame.margin);
  const auto most = hn::Set(doubles, 1 - frame.margin);
  alignas(64) std::array<std::array<float, 8>, 3> world;
  for (std::size_t first = 0; first < edges.size(); first += lanes) {
    const auto load = [&](const float* column) { return hn::PromoteTo(doubles, hn::LoadU(floats, column + first)); };
    const auto low = hn::Sub(load(edges.low()), isovalue);
    const auto high = hn::Sub(load(edges.high()), isovalue);
    const auto t = hn::Min(hn::Max(hn::Div(low, hn::Sub(low, high)), least), most);
    const auto index = [&](int axis) {
      const auto at_low =
          hn::Add(load(edges.offset(static_cast<std::size_t>(axis))), hn::Set(doubles, frame.origin[axis]));
      return axis == frame.axis ? hn::Add(at_low, t) : at_low;
    };
    const auto x = index(0);
    const auto y = index(1);
    const auto z = index(2);
    const auto& T = frame.T_world_index.matrix();
    for (int row = 0; row < 3; ++row) {
      const auto entry = [&](int column) { return hn::Set(doubles, T(row, column)); };
      const auto p =
          hn::Add(hn::Add(hn::Add(hn::Mul(entry(0), x), hn::Mul(entry(1), y)), hn::Mul(entry(2), z)), entry(3));
      hn::StoreU(hn::DemoteTo(floats, p), floats, world[static_cast<std::size_t>(row)].data());
    }
    const std::size_t count = std::min(lanes, edges.size() - first);
    for (std::size_t i = 0; i < count; ++i) p_world[first + i] = {world[0][i], world[1][i], world[2][i]};
  }
}

}  // namespace scanknit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scanknit {

HWY_EXPORT(crossing_points);

void crossing_points(const CrossingEdges& edges, const CrossingFrame& frame, std::span<Eigen::Vector3f> p_world) {
  HWY_DYNAMIC_DISPATCH(crossing_points)(edges, frame, p_world);
}

}  // namespace scanknit
#endif
