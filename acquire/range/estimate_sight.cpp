#include "acquire/range/estimate_sight.h"

#include <algorithm>
#include <vector>

#include "acquire/line_sums.h"
#include "core/median.h"
#include "core/range_scan.h"

namespace scanknit {
namespace {

constexpr std::size_t kFewestPoints = 20;  // on a line whose slope is believed
constexpr double kMostResidual = 0.2;      // of a step between neighbours
constexpr double kNearestSlitExtents = 2;  // slits nearer than so many depths of the scene are not believed

/// One row or column: where it crosses the plane, and its slope.
struct GridLine {
  double offset, slope;
};

/// Lines of constant row (`axis` 1) or column (`axis` 0), depth measured from `plane_z`.
std::vector<GridLine> lines_of(const Image<Eigen::Vector3f>& points, int axis, double plane_z, double step) {
  const int lines = axis == 1 ? points.height() : points.width();
  const int along = axis == 1 ? points.width() : points.height();
  std::vector<GridLine> found;
  for (int i = 0; i < lines; ++i) {
    LineSums sums;
    for (int j = 0; j < along; ++j) {
      const Eigen::Vector3f& p = axis == 1 ? points.at(j, i) : points.at(i, j);
      if (has_return(p)) sums.add(double{p.z()} - plane_z, double{p[axis]});
    }
    if (sums.n < static_cast<double>(kFewestPoints) || !(sums.variance() > step * step)) continue;
    if (sums.residual() < kMostResidual * step) found.push_back({sums.at_zero(), sums.slope()});
  }
  return found;
}

}  // namespace

SightLines estimate_sight(const Image<Eigen::Vector3f>& points) {
  SightLines sight{.kind = SightLines::Kind::kTwoSlits};
  std::vector<double> depths;
  std::vector<double> steps;
  for (int y = 0; y < points.height(); ++y) {
    for (int x = 0; x < points.width(); ++x) {
      if (!has_return(points.at(x, y))) continue;
      depths.push_back(double{points.at(x, y).z()});
      if (x > 0 && has_return(points.at(x - 1, y)))
        steps.push_back(std::abs(double{points.at(x, y).x()} - double{points.at(x - 1, y).x()}));
    }
  }
  if (depths.empty() || steps.empty()) return sight;
  sight.centre.z() = median(depths);
  const double step = median(steps);
  const auto [least, most] = std::minmax_element(depths.begin(), depths.end());
  for (const int axis : {0, 1}) {
    // offset = centre + slope * distance of the slit, with a minus: all lines meet at the slit.
    LineSums sums;
    for (const GridLine& line : lines_of(points, axis, sight.centre.z(), step)) sums.add(line.offset, line.slope);
    if (sums.n < static_cast<double>(kFewestPoints) || !(sums.variance() > 0)) continue;
    const double per_m = -sums.slope();  // slope = -(offset - centre) / distance
    if (!(std::abs(per_m) * (*most - *least) * kNearestSlitExtents < 1) || per_m == 0) continue;
    sight.slit_per_m[axis] = per_m;
    sight.centre[axis] = sums.at_zero() / per_m;
  }
  return sight;
}

}  // namespace scanknit
