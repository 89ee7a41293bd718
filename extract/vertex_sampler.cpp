#include "extract/vertex_sampler.h"

#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

/// The unit vector along `v`, or zero where its direction is not known.
Eigen::Vector3d direction(const Eigen::Vector3d& v) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length)) return Eigen::Vector3d::Zero();
  return v / length;
}

/// The colour of the coloured voxel nearest to `voxel` among the 26 around it; mid grey when there is none.
Eigen::Vector3d nearest_colour(const ColourBlock& colours, const Eigen::Vector3i& voxel) {
  constexpr double kMidGrey = 128.0 / 255.0;
  Eigen::Vector3d nearest = Eigen::Vector3d::Constant(kMidGrey);
  int nearest_squared = 4;  // more than a corner's 3
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i offset(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
    const Eigen::Vector3i at = voxel + offset;
    if (!ColourBlock::contains(at) || !has_colour(colours.at(at)) || offset.squaredNorm() >= nearest_squared) continue;
    nearest = colours.at(at).cast<double>();
    nearest_squared = offset.squaredNorm();
  }
  return nearest;
}

}  // namespace

SurfaceVertex VertexSampler::on_edge(const GridEdge& edge) const {
  const double t = parameter(edge);
  SurfaceVertex vertex{p_world(edge, t), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  if (config_.normals) vertex.outward = outward(edge, t);
  if (colours_ != nullptr) vertex.colour = colour(edge, t);
  return vertex;
}

SurfaceVertex VertexSampler::inside_cell(const Eigen::Vector3i& cell, std::span<const EdgeIndex> contour) const {
  SurfaceVertex sum{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (const EdgeIndex edge : contour) {
    const SurfaceVertex vertex = on_edge(grid_edge(cell, edge));
    sum.p_world += vertex.p_world;
    sum.outward += vertex.outward;
    sum.colour += vertex.colour;
  }
  const auto count = static_cast<double>(contour.size());
  return {sum.p_world / count, direction(sum.outward), sum.colour / count};
}

/// The zero of the linear interpolant, from 0 at the edge's low end to 1.
///
/// Where a sample equals the isovalue it would be 0 or 1, and vertices of up to six edges would coincide. So it keeps a
/// distance from the ends: 1/1024 of the edge, or four roundings of a float at this distance from the world's origin
/// where that is more (beyond 2^11 voxels). 2^-23 is a float's largest relative step, hence 2^-21 of the coordinate.
double VertexSampler::parameter(const GridEdge& edge) const {
  if (config_.placement == VertexPlacement::kMidEdge) return 0.5;
  const double coordinate_vox = p_world(edge, 0)[edge.axis] / frame_.voxel_size_m;
  const double margin = std::clamp(std::abs(coordinate_vox) * 0x1p-21, 0x1p-10, 0.25);
  const double at_low = static_cast<double>(values_.at(edge.low)) - config_.isovalue;
  const double at_high =
      static_cast<double>(values_.at(edge.low + Eigen::Vector3i::Unit(edge.axis))) - config_.isovalue;
  return std::clamp(at_low / (at_low - at_high), margin, 1 - margin);  // one is < 0, the other >= 0: never 0 / 0
}

Eigen::Vector3d VertexSampler::p_world(const GridEdge& edge, double t) const {
  const Eigen::Vector3d index = (origin_ + edge.low).cast<double>() + t * Eigen::Vector3d::Unit(edge.axis);
  return frame_.voxel_size_m * index + frame_.translation_m;
}

/// Central differences where both neighbours were observed, else one-sided ones.
Eigen::Vector3d VertexSampler::gradient(const Eigen::Vector3i& voxel) const {
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
    const float before = values_.at(voxel - step);
    const float after = values_.at(voxel + step);
    const double low = static_cast<double>(is_observed(before) ? before : values_.at(voxel));
    const double high = static_cast<double>(is_observed(after) ? after : values_.at(voxel));
    const int steps = static_cast<int>(is_observed(before)) + static_cast<int>(is_observed(after));
    if (steps > 0) result[axis] = (high - low) / steps;
  }
  return result;
}

Eigen::Vector3d VertexSampler::outward(const GridEdge& edge, double t) const {
  const Eigen::Vector3d towards_high =
      (1 - t) * gradient(edge.low) + t * gradient(edge.low + Eigen::Vector3i::Unit(edge.axis));
  return direction(frame_.inside_is_high ? Eigen::Vector3d(-towards_high) : towards_high);
}

Eigen::Vector3d VertexSampler::colour(const GridEdge& edge, double t) const {
  const Eigen::Vector3i high = edge.low + Eigen::Vector3i::Unit(edge.axis);
  const Eigen::Vector3f& at_low = colours_->at(edge.low);
  const Eigen::Vector3f& at_high = colours_->at(high);
  if (has_colour(at_low) && has_colour(at_high)) return (1 - t) * at_low.cast<double>() + t * at_high.cast<double>();
  if (has_colour(at_low)) return at_low.cast<double>();
  if (has_colour(at_high)) return at_high.cast<double>();
  return nearest_colour(*colours_, t < 0.5 ? edge.low : high);
}

}  // namespace scanknit
