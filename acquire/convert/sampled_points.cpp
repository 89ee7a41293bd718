#include "acquire/convert/sampled_points.h"

#include "acquire/convert/recording_target.h"

namespace scanknit {
namespace {

constexpr int kPointStep = 4;  // pixels of depth from one point to the next
constexpr std::size_t kMostPoints = 100000;

}  // namespace

void SampledPoints::add(const Frame& frame) {
  for (int y = 0; y < frame.depth_m.height(); y += kPointStep) {
    for (int x = 0; x < frame.depth_m.width(); x += kPointStep) {
      const auto point = coloured_point(frame, x, y);
      if (point) offer({(*frame.T_world_camera * point->p_depth).cast<float>(), point->colour});
    }
  }
}

void SampledPoints::offer(const SampledPoint& point) {
  ++offered_;
  if (points_.size() < kMostPoints) return points_.push_back(point);
  const std::uint64_t place = random_() % offered_;
  if (place < kMostPoints) points_[place] = point;
}

}  // namespace scanknit
