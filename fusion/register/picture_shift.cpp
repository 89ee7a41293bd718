#include "fusion/register/picture_shift.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/rotation.h"

namespace scanknit {
namespace {

constexpr int kStep = 2;              // pixels of the coarsest level between shifts, and between samples
constexpr int kReach = 12;            // 11 degrees for a Kinect
constexpr float kDepthShare = 0.1f;   // a depth that differs by more than this of itself is all wrong
constexpr float kIntensity = 0.2f;    // so is an intensity
constexpr float kFewestShare = 0.3f;  // of the samples must be seen in both

/// Mean difference, 0 to 1, of the frame and the model when pixel (x, y) of the frame lies at (x + dx, y + dy).
float difference(const SurfaceLevel& frame, const SurfaceLevel& model, int dx, int dy) {
  const int width = frame.intrinsics.width;
  const int height = frame.intrinsics.height;
  float sum = 0;
  float count = 0;
  float samples = 0;
  for (int y = 0; y < height; y += kStep) {
    for (int x = 0; x < width; x += kStep) {
      samples += 1;
      const int mx = x + dx;
      const int my = y + dy;
      if (mx < 0 || my < 0 || mx >= width || my >= height) continue;
      const std::size_t i = frame.index(x, y);
      const std::size_t j = model.index(mx, my);
      if (!(frame.z_m[i] > 0) || !(model.z_m[j] > 0)) continue;
      float off = std::min(1.0f, std::abs(frame.z_m[i] - model.z_m[j]) / (kDepthShare * model.z_m[j]));
      if (frame.intensity[i] >= 0 && model.intensity[j] >= 0) {
        off = 0.5f * (off + std::min(1.0f, std::abs(frame.intensity[i] - model.intensity[j]) / kIntensity));
      }
      sum += off;
      count += 1;
    }
  }
  return count < kFewestShare * samples ? 1.0f : sum / count;
}

}  // namespace

Pose turn_by_shift(const SurfacePyramid& frame, const SurfacePyramid& model) {
  const SurfaceLevel& seen = frame.levels.back();
  const SurfaceLevel& known = model.levels.back();
  constexpr int kSide = 2 * (kReach / kStep) + 1;
  std::vector<float> differences(static_cast<std::size_t>(kSide * kSide));
  const auto shift_of = [](int place) { return (place - kSide / 2) * kStep; };
  tbb::parallel_for(0, kSide * kSide, [&](int i) {
    differences[static_cast<std::size_t>(i)] = difference(seen, known, shift_of(i % kSide), shift_of(i / kSide));
  });
  const auto best = std::min_element(differences.begin(), differences.end());
  const float unmoved = differences[differences.size() / 2];
  if (!(*best < unmoved)) return Pose::Identity();
  const int place = static_cast<int>(best - differences.begin());
  const Eigen::Vector3d ray(shift_of(place % kSide) / known.intrinsics.fx,
                            shift_of(place / kSide) / known.intrinsics.fy, 1);
  Pose turn = Pose::Identity();
  turn.linear() = rotation_between(Eigen::Vector3d::UnitZ(), ray).toRotationMatrix();
  return turn;
}

}  // namespace scanknit
