#include "fusion/range/range_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/median.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// An edge longer than so many spacings crosses a step in depth: at such a slope, 73 degrees off the line of sight, a
/// scanner measures little, and so far apart that nobody knows what is between.
constexpr double kLongestEdge = 3.5;

/// How often normals are averaged with their neighbours': the noise of a point is as large as a spacing is long.
constexpr int kNormalRounds = 3;

constexpr std::size_t kMostSamples = 20'000;  // for a median

/// How far apart neighbours are when nothing lies between them: of a sphere it grows with the range.
class Spacing {
 public:
  explicit Spacing(const RangeScan& scan) : scan_(scan), is_angular_(scan.sight.kind == SightLines::Kind::kSphere) {
    const auto& points = scan.points_m;
    std::vector<double> steps;
    for (int y = 0; y < points.height(); ++y) {
      for (int x = 1; x < points.width(); ++x) add(points.at(x - 1, y), points.at(x, y), steps);
    }
    unit_ = median(std::move(steps));
    std::vector<double> down;
    for (int y = 1; y < points.height(); ++y) {
      for (int x = 0; x < points.width(); ++x) add(points.at(x, y - 1), points.at(x, y), down);
    }
    unit_ = std::max(unit_, median(std::move(down)));
  }

  [[nodiscard]] double at(const Vector3f& p) const { return unit_ * scale(p); }

 private:
  [[nodiscard]] double scale(const Vector3f& p) const {
    return is_angular_ ? (p.cast<double>() - scan_.sight.centre).norm() : 1;
  }
  void add(const Vector3f& a, const Vector3f& b, std::vector<double>& steps) const {
    if (has_return(a) && has_return(b)) steps.push_back((a - b).cast<double>().norm() / scale(a));
  }

  const RangeScan& scan_;
  bool is_angular_;
  double unit_ = 0;
};

class SurfaceFinder {
 public:
  explicit SurfaceFinder(const RangeScan& scan)
      : scan_(scan), points_(scan.points_m), spacing_(scan), width_(points_.width()), height_(points_.height()) {}

  [[nodiscard]] RangeSurface find() {
    surface_.normals = Image<Vector3f>(width_, height_, Vector3f::Zero());
    surface_.inset = Image<std::uint8_t>(width_, height_);
    for (int y = 1; y < height_; ++y) {
      for (int x = 1; x < width_; ++x) split(x, y);
    }
    for (Vector3f& normal : surface_.normals.pixels()) normal = unit(normal);
    for (int round = 0; round < kNormalRounds; ++round) smooth_normals();
    find_insets();
    measure();
    return std::move(surface_);
  }

 private:
  static Vector3f unit(const Vector3f& v) {
    const float length = v.norm();
    return length > 0 ? Vector3f(v / length) : Vector3f::Zero();
  }
  [[nodiscard]] std::uint32_t cell(int x, int y) const {
    return static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width_) + static_cast<std::uint32_t>(x);
  }
  [[nodiscard]] const Vector3f& point(std::uint32_t at) const { return points_.pixels()[at]; }

  [[nodiscard]] bool is_joined(const Vector3f& a, const Vector3f& b) const {
    return has_return(a) && has_return(b) && (a - b).cast<double>().norm() <= kLongestEdge * spacing_.at(a);
  }

  /// The square whose last corner is (x, y), as two triangles along its shorter diagonal, or as one.
  void split(int x, int y) {
    const std::uint32_t a = cell(x - 1, y - 1), b = cell(x, y - 1), c = cell(x, y), d = cell(x - 1, y);
    const auto diagonal = [&](std::uint32_t i, std::uint32_t k) {
      const bool is_there = has_return(point(i)) && has_return(point(k));
      return is_there ? (point(i) - point(k)).norm() : HUGE_VALF;
    };
    if (diagonal(a, c) <= diagonal(b, d)) {
      add(a, c, b);
      add(a, d, c);
    } else {
      add(a, d, b);
      add(b, d, c);
    }
  }

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Vector3f &pa = point(a), &pb = point(b), &pc = point(c);
    if (!is_joined(pa, pb) || !is_joined(pb, pc) || !is_joined(pc, pa)) return;
    const Vector3f across = (pb - pa).cross(pc - pa);
    const Vector3d towards = -scan_.sight.direction(pa.cast<double>());
    const bool is_front = across.cast<double>().dot(towards) > 0;
    surface_.triangles.push_back(is_front ? Triangle(a, b, c) : Triangle(a, c, b));
    const Vector3f normal = is_front ? across : Vector3f(-across);
    for (const std::uint32_t at : {a, b, c}) surface_.normals.pixels()[at] += normal;
  }

  template <typename Visit>
  void for_each_joined(int x, int y, const Visit& visit) const {
    for (const auto& [dx, dy] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)}) {
      if (!points_.contains(x + dx, y + dy)) continue;
      if (surface_.normals.at(x + dx, y + dy).isZero(0)) continue;
      if (is_joined(points_.at(x, y), points_.at(x + dx, y + dy))) visit(x + dx, y + dy);
    }
  }

  void smooth_normals() {
    Image<Vector3f> smooth(width_, height_, Vector3f::Zero());
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (surface_.normals.at(x, y).isZero(0)) continue;
        Vector3f sum = 2 * surface_.normals.at(x, y);
        for_each_joined(x, y, [&](int nx, int ny) { sum += surface_.normals.at(nx, ny); });
        smooth.at(x, y) = unit(sum);
      }
    }
    surface_.normals = std::move(smooth);
  }

  /// 1 at the rim, where one of four neighbours is missing, and one more for each step inwards.
  void find_insets() {
    for (int depth = 1; depth <= RangeSurface::kDeepest; ++depth) {
      const Image<std::uint8_t> before = surface_.inset;
      for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
          if (surface_.normals.at(x, y).isZero(0)) continue;
          int deep = 0;
          for_each_joined(x, y, [&](int nx, int ny) { deep += before.at(nx, ny) >= depth - 1 ? 1 : 0; });
          if (depth == 1 || (deep == 4 && before.at(x, y) == depth - 1)) {
            surface_.inset.at(x, y) = static_cast<std::uint8_t>(depth);
          }
        }
      }
    }
  }

  /// Spacing, and noise: how far a point is off the middle of its two neighbours. The sum of the three has 1.5 times
  /// the variance of one; 1.4826 medians of the absolute value are a standard deviation.
  void measure() {
    std::vector<double> steps;
    std::vector<double> off;
    const std::size_t every = std::max<std::size_t>(1, surface_.triangles.size() / kMostSamples);
    for (std::size_t t = 0; t < surface_.triangles.size(); t += every) {
      const std::uint32_t at = surface_.triangles[t][0];
      const int x = static_cast<int>(at % static_cast<std::uint32_t>(width_));
      const int y = static_cast<int>(at / static_cast<std::uint32_t>(width_));
      steps.push_back(spacing_.at(point(at)));
      if (surface_.inset.at(x, y) < 2) continue;
      const Vector3f middle = (points_.at(x - 1, y) + points_.at(x + 1, y)) / 2;
      off.push_back(std::abs(double{surface_.normals.at(x, y).dot(points_.at(x, y) - middle)}));
    }
    surface_.spacing_m = median(std::move(steps));
    surface_.noise_m = median(std::move(off)) * 1.4826 / std::sqrt(1.5);
  }

  const RangeScan& scan_;
  const Image<Vector3f>& points_;
  Spacing spacing_;
  int width_, height_;
  RangeSurface surface_;
};

}  // namespace

RangeSurface find_surface(const RangeScan& scan) {
  return SurfaceFinder(scan).find();
}

}  // namespace scanknit
