#include "extract/vertex_sampler.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "extract/blocks/crossing_points.h"

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

/// Slightly different: the plain mean of a symmetric cell's vertices lies in line with two of them, which makes a
/// triangle without area.
constexpr std::array<double, kEdges> kEdgeWeights = {1.00, 1.07, 0.93, 1.13, 0.89, 1.04,
                                                     1.17, 0.96, 1.10, 0.86, 1.02, 0.91};

}  // namespace

Rgb8 SurfaceVertex::rgb() const {
  const auto byte = [](double channel) {
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(channel, 0.0, 1.0)));
  };
  return {byte(colour.x()), byte(colour.y()), byte(colour.z())};
}

SamplingFrame::SamplingFrame(const Eigen::Affine3d& world_from_index, bool is_inside_high)
    : T_world_index(world_from_index),
      outward_from_gradient((is_inside_high ? -1.0 : 1.0) * world_from_index.linear().inverse().transpose()),
      edge_length(world_from_index.linear().colwise().norm().transpose()) {}

VertexSampler::VertexSampler(const ValueBlock& values, const ColourBlock* colours, const Eigen::Vector3i& origin,
                             const SamplingFrame& frame, const ExtractConfig& config)
    : values_(values), colours_(colours), origin_(origin), frame_(frame), config_(config) {
  for (int axis = 0; axis < 3; ++axis) margins_[axis] = margin(origin, axis);
}

/// How near a vertex may come to the ends of its edge, as a part of it. Where a sample equals the isovalue it would lie
/// on the sample, and vertices of up to six edges would coincide. So it keeps 1/1024 of the edge away, or four
/// roundings of a float at this distance from the world's origin where that is more. 2^-23 is a float's largest
/// relative step, hence 2^-21 of the coordinate. One value for all edges that a block owns, which is all that other
/// blocks need to know.
double VertexSampler::margin(const Eigen::Vector3i& owner, int axis) const {
  const double block_reach = kBlockCells * frame_.edge_length.sum();
  const double farthest = (frame_.T_world_index * owner.cast<double>()).cwiseAbs().maxCoeff() + block_reach;
  return std::clamp(farthest / frame_.edge_length[axis] * 0x1p-21, 0x1p-10, 0.25);
}

std::size_t VertexSampler::write_positions(int axis, const VoxelBits& edges, Eigen::Vector3f* p_world) const {
  CrossingEdges crossing;
  for (int x = 0; x < kBlockCells; ++x) {
    for (std::uint64_t bits = edges[static_cast<std::size_t>(x)]; bits != 0; bits &= bits - 1) {
      const int y = std::countr_zero(bits) / kBlockCells;
      const int z = std::countr_zero(bits) % kBlockCells;
      crossing.push_back(x, y, z, values_.at(x, y, z), values_.at(x + (axis == 0), y + (axis == 1), z + (axis == 2)));
    }
  }
  const double at_least = config_.placement == VertexPlacement::kMidEdge ? 0.5 : margins_[axis];
  crossing_points(crossing, {axis, config_.isovalue, at_least, origin_.cast<double>(), frame_.T_world_index},
                  {p_world, crossing.size()});
  return crossing.size();
}

/// The zero of the linear interpolant, from 0 at the edge's low end to 1, kept away from the ends.
double VertexSampler::parameter(const GridEdge& edge) const {
  if (config_.placement == VertexPlacement::kMidEdge) return 0.5;
  const auto& [low, axis] = edge;
  const Eigen::Vector3i owner = low / kBlockCells * kBlockCells;  // 8 belongs to the next block
  const double at_least = owner.isZero() ? margins_[axis] : margin(origin_ + owner, axis);
  const double at_low = static_cast<double>(values_.at(low)) - config_.isovalue;
  const double at_high = static_cast<double>(values_.at(low + Eigen::Vector3i::Unit(axis))) - config_.isovalue;
  return std::clamp(at_low / (at_low - at_high), at_least, 1 - at_least);  // < 0 and >= 0: never 0 / 0
}

/// The same order of sums as in crossing_points: the same bits.
Eigen::Vector3d VertexSampler::p_world(const GridEdge& edge, double t) const {
  Eigen::Vector3d index = (origin_ + edge.low).cast<double>();
  index[edge.axis] += t;
  const auto& T = frame_.T_world_index;
  return ((T.linear().col(0) * index.x() + T.linear().col(1) * index.y()) + T.linear().col(2) * index.z()) +
         T.translation();
}

SurfaceVertex VertexSampler::on_edge(const GridEdge& edge) const {
  const double t = parameter(edge);
  SurfaceVertex vertex{p_world(edge, t), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  if (config_.normals) vertex.outward = outward(edge, t);
  if (colours_ != nullptr) vertex.colour = colour(edge, t);
  return vertex;
}

SurfaceVertex VertexSampler::inside_cell(const Eigen::Vector3i& cell, EdgeMask edges) const {
  SurfaceVertex sum{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double total = 0;
  for (unsigned left = edges; left != 0; left &= left - 1) {
    const int edge = std::countr_zero(left);
    const double weight = kEdgeWeights[static_cast<std::size_t>(edge)];
    const SurfaceVertex vertex = on_edge(grid_edge(cell, edge));
    sum.p_world += weight * vertex.p_world;
    sum.outward += weight * vertex.outward;
    sum.colour += weight * vertex.colour;
    total += weight;
  }
  return {sum.p_world / total, direction(sum.outward), sum.colour / total};
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
  return direction(frame_.outward_from_gradient * towards_high);
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
