#include "fusion/turntable/still_scene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr double kSigmas = 3;          // depths that differ by less are one depth
constexpr double kMostly = 0.85;       // of what a pixel saw: it never saw anything else
constexpr double kSeen = 0.5;          // of the pictures must show something there
constexpr double kAtTimes = 0.1;       // of the pictures show what is behind
constexpr double kBetween = 0.15;      // of those: at most so many lie in the gap before it (flying pixels)
constexpr double kGap_m = 0.02;        // a rounder object comes nearer and goes by as much
constexpr double kGapSigmas = 6;       // and noise by as much
constexpr double kFewestStill = 0.02;  // of the pixels: fewer are chance
constexpr double kMaskSigmas = 4;      // a reading so much nearer than what is still is something else
constexpr double kRarely = 0.3;        // as often as usual
constexpr std::size_t kFewestViews = 3;

/// `depths_m` ascending. 0: nothing that is still is known.
float still_depth(const std::vector<float>& depths_m, std::size_t pictures, const NoiseModel& noise, bool& is_always) {
  const auto seen = static_cast<double>(depths_m.size());
  is_always = false;
  if (depths_m.size() < kFewestViews) return 0;
  const auto count_within = [&](double near_m, double far_m) {
    const auto begin = std::lower_bound(depths_m.begin(), depths_m.end(), static_cast<float>(near_m));
    return static_cast<double>(std::upper_bound(begin, depths_m.end(), static_cast<float>(far_m)) - begin);
  };
  const auto mean_within = [&](double near_m, double far_m) {  // finer than the steps of a sensor's disparity
    const auto begin = std::lower_bound(depths_m.begin(), depths_m.end(), static_cast<float>(near_m));
    const auto end = std::upper_bound(begin, depths_m.end(), static_cast<float>(far_m));
    return static_cast<float>(std::accumulate(begin, end, 0.0) / static_cast<double>(end - begin));
  };
  const double median = static_cast<double>(depths_m[depths_m.size() / 2]);
  const double around = kSigmas * noise.sigma_m(median);
  if (seen >= kSeen * static_cast<double>(pictures) &&
      count_within(median - around, median + around) >= kMostly * seen) {
    is_always = true;
    return mean_within(median - around, median + around);
  }
  // The farthest depth that is seen at times.
  const double fewest = std::max(static_cast<double>(kFewestViews), kAtTimes * static_cast<double>(pictures));
  for (std::size_t last = depths_m.size(); last-- > 0;) {
    const double far_m = static_cast<double>(depths_m[last]);
    const double sigma = noise.sigma_m(far_m);
    const double near_m = far_m - 2 * kSigmas * sigma;
    const double there = count_within(near_m, far_m);
    if (there < fewest) continue;
    const double gap_m = kGap_m + kGapSigmas * sigma;
    const double between = count_within(near_m - gap_m, far_m) - there;
    return between > kBetween * there ? 0 : mean_within(near_m, far_m);
  }
  return 0;
}

/// Pixels with fewer than three of their eight neighbours.
bool is_lone(const DepthImage& depth_m, int x, int y) {
  constexpr int kFewestNeighbours = 3;
  int neighbours = 0;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if ((u != x || v != y) && depth_m.contains(u, v) && depth_m.at(u, v) > 0) ++neighbours;
    }
  }
  return neighbours < kFewestNeighbours;
}

}  // namespace

StillScene StillScene::learn(const std::vector<DepthImage>& samples, const NoiseModel& noise) {
  StillScene still;
  still.noise_ = noise;
  if (samples.size() < kFewestViews) return still;
  const int width = samples.front().width();
  const int height = samples.front().height();
  for (const DepthImage& sample : samples) SCANKNIT_CHECK(sample.width() == width && sample.height() == height);
  still.depth_m_ = DepthImage(width, height);
  std::vector<std::size_t> always(static_cast<std::size_t>(height));
  tbb::parallel_for(0, height, [&](int y) {
    std::vector<float> depths_m;
    for (int x = 0; x < width; ++x) {
      depths_m.clear();
      for (const DepthImage& sample : samples) {
        if (sample.at(x, y) > 0) depths_m.push_back(sample.at(x, y));
      }
      std::sort(depths_m.begin(), depths_m.end());
      bool is_always = false;
      still.depth_m_.at(x, y) = still_depth(depths_m, samples.size(), noise, is_always);
      always[static_cast<std::size_t>(y)] += is_always;
    }
  });
  std::size_t total = 0;
  for (const std::size_t row : always) total += row;
  if (static_cast<double>(total) < kFewestStill * static_cast<double>(still.depth_m_.size())) still.depth_m_ = {};
  if (!still.empty()) still.find_rare(samples);
  return still;
}

/// In front of what stands still.
bool StillScene::is_other(float z_m, float still_m) const {
  if (!(z_m > 0)) return false;
  if (!(still_m > 0)) return true;
  const double nearer = kMaskSigmas * noise_.sigma_m(static_cast<double>(still_m));
  return static_cast<double>(z_m) <= static_cast<double>(still_m) - nearer;
}

void StillScene::find_rare(const std::vector<DepthImage>& samples) {
  Image<std::uint16_t> times(depth_m_.width(), depth_m_.height());
  std::vector<std::size_t> pixels(samples.size() + 1);  // by how often something comes by
  tbb::parallel_for(0, depth_m_.height(), [&](int y) {
    for (int x = 0; x < depth_m_.width(); ++x) {
      const auto count = std::count_if(samples.begin(), samples.end(), [&](const DepthImage& sample) {
        return is_other(sample.at(x, y), depth_m_.at(x, y));
      });
      times.at(x, y) = static_cast<std::uint16_t>(count);
    }
  });
  std::size_t total = 0;
  for (const std::uint16_t count : times.pixels()) {
    ++pixels[count];
    total += count;
  }
  // Half of all that comes by does so where it comes by at least `usual` times.
  std::size_t usual = samples.size();
  for (std::size_t sum = 0; usual > 0; --usual) {
    sum += usual * pixels[usual];
    if (2 * sum >= total) break;
  }
  is_rare_ = Image<std::uint8_t>(depth_m_.width(), depth_m_.height());
  for (std::size_t i = 0; i < times.size(); ++i) {
    is_rare_.pixels()[i] = static_cast<double>(times.pixels()[i]) < kRarely * static_cast<double>(usual);
  }
}

void StillScene::remove_from(DepthImage& depth_m) const {
  if (empty() || depth_m.width() != depth_m_.width() || depth_m.height() != depth_m_.height()) return;
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const float still_m = depth_m_.pixels()[i];
    float& z_m = depth_m.pixels()[i];
    if (is_rare_.pixels()[i] != 0 || !is_other(z_m, still_m)) z_m = 0;
  }
  const DepthImage rest = depth_m;
  for (int y = 0; y < rest.height(); ++y) {
    for (int x = 0; x < rest.width(); ++x) {
      if (rest.at(x, y) > 0 && is_lone(rest, x, y)) depth_m.at(x, y) = 0;
    }
  }
}

}  // namespace scanknit
