#include "scan/frames/depth_samples.h"

#include <algorithm>
#include <utility>

namespace scanknit {
namespace {

constexpr std::size_t kMostSamples = 48;
constexpr int kMostColumns = 320;

/// Every step-th pixel of every step-th row.
DepthImage thinned(const DepthImage& depth_m, int step) {
  DepthImage thin((depth_m.width() + step - 1) / step, (depth_m.height() + step - 1) / step);
  for (int y = 0; y < thin.height(); ++y) {
    for (int x = 0; x < thin.width(); ++x) thin.at(x, y) = depth_m.at(step * x, step * y);
  }
  return thin;
}

}  // namespace

void DepthSamples::add(const Frame& frame) {
  if (seen_++ % every_ != 0) return;
  const int step = (frame.depth_m.width() + kMostColumns - 1) / kMostColumns;
  if (step < 1) return;
  CameraIntrinsics camera = frame.intrinsics;
  camera.fx /= step;
  camera.fy /= step;
  camera.cx /= step;
  camera.cy /= step;
  DepthImage depth_m = thinned(frame.depth_m, step);
  camera.width = depth_m.width();
  camera.height = depth_m.height();
  samples_.push_back({frame.sequence, std::move(depth_m), camera});
  if (samples_.size() <= kMostSamples) return;
  every_ *= 2;
  std::vector<Sample> kept;
  for (std::size_t i = 0; i < samples_.size(); i += 2) kept.push_back(std::move(samples_[i]));
  samples_ = std::move(kept);
}

void DepthSamples::clear() {
  *this = DepthSamples();
}

std::vector<std::uint64_t> DepthSamples::sequences() const {
  std::vector<std::uint64_t> sequences;
  for (const Sample& sample : samples_) sequences.push_back(sample.sequence);
  return sequences;
}

std::size_t DepthSamples::spacing(std::size_t frames) {
  std::size_t every = 1;
  while (frames > kMostSamples * every) every *= 2;
  return every;
}

std::vector<PosedDepth> DepthSamples::posed(const Trajectory& trajectory) const {
  const PosesBySequence poses = poses_of(trajectory);
  std::vector<PosedDepth> posed;
  for (const Sample& sample : samples_) {
    const auto found = poses.find(sample.sequence);
    if (found != poses.end()) posed.push_back({&sample.depth_m, sample.intrinsics, found->second});
  }
  return posed;
}

}  // namespace scanknit
