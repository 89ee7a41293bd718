#include "synth/scene/texture.h"

#include <algorithm>
#include <cmath>

#include "core/counter_random.h"

namespace scanknit {
namespace {

/// A lattice value in [0, 1], a pure function of the lattice point.
double lattice_value(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto key = [](std::int64_t v) { return static_cast<std::uint64_t>(v); };
  return static_cast<double>(mix64(mix64(mix64(key(x) + 1) + key(y)) + key(z)) >> 11) * 0x1p-53;
}

double smooth_step(double x) {
  return x * x * (3 - 2 * x);
}

/// 0 or 1 in alternating half periods.
double square_wave(double x) {
  return static_cast<double>(static_cast<std::int64_t>(std::floor(x)) & 1);
}

double pattern_value(Pattern pattern, const Eigen::Vector3d& q) {
  switch (pattern) {
    case Pattern::kChecks: {
      // The odd offsets keep the faces of solids off the boundaries between layers of checks.
      const double parity = square_wave(q.x() + 0.37) + square_wave(q.y() + 0.37) + square_wave(q.z() + 0.37);
      return parity == 1 || parity == 3 ? 1 : 0;
    }
    case Pattern::kStripes: return square_wave((q.x() + q.y() + q.z()) / 1.7320508 + 0.37);
    case Pattern::kMarble: return 0.5 + 0.5 * std::sin(2 * q.x() + 3 * q.z() + 6 * smooth_noise(q));
  }
  return 0;
}

}  // namespace

double smooth_noise(const Eigen::Vector3d& p) {
  const Eigen::Vector3d cell = p.array().floor();
  const Eigen::Vector3d w = (p - cell).unaryExpr(&smooth_step);
  const auto x = static_cast<std::int64_t>(cell.x());
  const auto y = static_cast<std::int64_t>(cell.y());
  const auto z = static_cast<std::int64_t>(cell.z());
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1;
    const int j = (corner >> 1) & 1;
    const int k = corner >> 2;
    sum += (i == 1 ? w.x() : 1 - w.x()) * (j == 1 ? w.y() : 1 - w.y()) * (k == 1 ? w.z() : 1 - w.z()) *
           lattice_value(x + i, y + j, z + k);
  }
  return sum;
}

Eigen::Vector3d texture_colour(const Texture& texture, const Eigen::Vector3d& p_solid) {
  const Eigen::Vector3d q = p_solid / texture.period_m;
  const double mix = pattern_value(texture.pattern, q);
  const double mottle = (smooth_noise(0.7 * q) + 0.5 * smooth_noise(2.3 * q)) / 1.5;
  const Eigen::Vector3d base = texture.dark + mix * (texture.light - texture.dark);
  return ((0.6 + 0.6 * mottle) * base).cwiseMax(0.0).cwiseMin(1.0);
}

}  // namespace scanknit
