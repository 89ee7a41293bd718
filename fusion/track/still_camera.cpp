#include "fusion/track/still_camera.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fusion/register/contradiction.h"

namespace scanknit {
namespace {

constexpr int kTile = 20;                 // pixels
constexpr double kLeastFilled = 0.5;      // of a tile's pixels
constexpr double kComparableShare = 0.4;  // of the tiles with depth: who moves hides two places, the old and the new
constexpr double kStillShare = 0.6;       // of the tiles that can be compared
constexpr std::size_t kFewestTiles = 8;   // with a pattern

// The mean of a tile is better known than one of its pixels, whose errors are alike within it.
constexpr double kMeanSigmas = 1;

constexpr double kStill_px = 0.06;        // 0.4 mm at 2 m for a Kinect, less than what tracking wavers
constexpr double kFarthest_px = 0.5;      // what differs by more has not been moved, but is another pattern
constexpr double kIntensityNoise = 0.03;  // standard deviation
constexpr double kLeastPattern = 0.5;     // sum of squared gradients: the shift is known to 0.04 pixels

struct Tile {
  bool is_filled = false;      ///< with depth
  bool is_comparable = false;  ///< most of it shows the same surface in both pictures
  bool has_same_depth = false;
  bool has_pattern = false;
  double shift_px = 0;  ///< along the direction in which the pattern tells most
};

/// Least squares of a shift, by the gradients; gain and offset of the brightness are free.
class PatternSums {
 public:
  void add(const Eigen::Vector2d& gradient, double intensity, double difference) {
    const Eigen::Vector4d row(gradient.x(), gradient.y(), intensity, difference);
    count_ += 1;
    sum_ += row;
    products_ += row * row.transpose();
  }

  void describe(Tile& tile) const {
    if (count_ < kLeastFilled * kTile * kTile) return;
    Eigen::Matrix4d rest = products_ - sum_ * sum_.transpose() / count_;
    const Eigen::Vector4d with_intensity = rest.col(2);
    if (with_intensity(2) > 0) rest -= with_intensity * with_intensity.transpose() / with_intensity(2);
    const Eigen::Matrix2d gradients = rest.topLeftCorner<2, 2>();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(gradients);
    const double pattern = eigen.eigenvalues()(1);
    tile.has_pattern = pattern >= kLeastPattern;
    if (!tile.has_pattern) return;
    const double most = kFarthest_px * kFarthest_px * gradients.trace() + count_ * kIntensityNoise * kIntensityNoise;
    tile.shift_px = rest(3, 3) > most ? std::numeric_limits<double>::infinity()
                                      : std::abs(eigen.eigenvectors().col(1).dot(rest.block<2, 1>(0, 3))) / pattern;
  }

 private:
  double count_ = 0;
  Eigen::Vector4d sum_ = Eigen::Vector4d::Zero();
  Eigen::Matrix4d products_ = Eigen::Matrix4d::Zero();
};

Tile compare_tile(const SurfaceLevel& now, const SurfaceLevel& before, const NoiseModel& noise, int left, int top) {
  int filled = 0, alike = 0;
  double deviation = 0;  // sum, in sigmas
  PatternSums sums;
  for (int y = top; y < top + kTile; ++y) {
    for (int x = left; x < left + kTile; ++x) {
      const std::size_t i = now.index(x, y);
      const double z_m = now.z_m[i];
      if (!(z_m > 0)) continue;
      ++filled;
      if (!(before.z_m[i] > 0)) continue;
      const double farther_m = z_m - before.z_m[i];
      if (std::abs(farther_m) > contradiction_m(noise, z_m)) continue;
      ++alike;
      deviation += farther_m / noise.sigma_m(z_m);
      if (now.intensity[i] < 0 || before.intensity[i] < 0) continue;
      const Eigen::Vector2d gradient(0.5 * (now.gx[i] + before.gx[i]), 0.5 * (now.gy[i] + before.gy[i]));
      sums.add(gradient, before.intensity[i], now.intensity[i] - before.intensity[i]);
    }
  }
  Tile tile;
  tile.is_filled = filled >= kLeastFilled * kTile * kTile;
  tile.is_comparable = tile.is_filled && alike > kLeastFilled * filled;
  if (!tile.is_comparable) return tile;
  tile.has_same_depth = std::abs(deviation) < kMeanSigmas * alike;
  sums.describe(tile);
  return tile;
}

}  // namespace

bool stands_still(const SurfaceLevel& now, const SurfaceLevel& before, const NoiseModel& noise) {
  const int columns = now.intrinsics.width / kTile;
  const int rows = now.intrinsics.height / kTile;
  std::vector<Tile> tiles(static_cast<std::size_t>(columns * rows));
  tbb::parallel_for(0, rows, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      tiles[static_cast<std::size_t>(row * columns + column)] =
          compare_tile(now, before, noise, column * kTile, row * kTile);
    }
  });
  std::size_t filled = 0, comparable = 0, same_depth = 0, patterns = 0, still = 0;
  for (const Tile& tile : tiles) {
    filled += tile.is_filled;
    comparable += tile.is_comparable;
    same_depth += tile.has_same_depth;
    patterns += tile.has_pattern;
    still += tile.has_pattern && tile.shift_px < kStill_px;
  }
  const auto is_share = [](std::size_t part, double share, std::size_t whole) {
    return static_cast<double>(part) >= share * static_cast<double>(whole);
  };
  return patterns >= kFewestTiles && is_share(comparable, kComparableShare, filled) &&
         is_share(same_depth, kStillShare, comparable) && is_share(still, kStillShare, patterns);
}

}  // namespace scanknit
