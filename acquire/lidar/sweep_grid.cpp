#include "acquire/lidar/sweep_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "core/median.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kMostRows = 512;
constexpr std::size_t kFewestInRow = 8;  // fewer points are strays, not a laser

/// From 0 to a whole turn.
double azimuth_of(const Vector3f& p) {
  const double angle = std::atan2(static_cast<double>(p.y()), static_cast<double>(p.x()));
  return angle < 0 ? angle + kFullTurn : angle;
}

double elevation_of(const Vector3f& p) {
  return std::atan2(static_cast<double>(p.z()), std::hypot(static_cast<double>(p.x()), static_cast<double>(p.y())));
}

/// Groups, numbered by the mean elevation of their points, the highest 0.
SweepRows rows_from_groups(const std::vector<Vector3f>& points, const std::vector<std::uint16_t>& groups,
                           SweepRows::Kind kind) {
  std::vector<std::pair<double, std::size_t>> sums(std::size_t{1} + *std::max_element(groups.begin(), groups.end()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    sums[groups[i]].first += elevation_of(points[i]);
    ++sums[groups[i]].second;
  }
  std::vector<std::uint16_t> order;
  for (std::size_t group = 0; group < sums.size(); ++group) {
    if (sums[group].second > 0) order.push_back(static_cast<std::uint16_t>(group));
  }
  const auto mean = [&](std::uint16_t group) { return sums[group].first / static_cast<double>(sums[group].second); };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return mean(a) > mean(b); });
  std::vector<std::uint16_t> row_of_group(sums.size());
  for (std::size_t row = 0; row < order.size(); ++row) row_of_group[order[row]] = static_cast<std::uint16_t>(row);
  SweepRows rows{kind, {}, static_cast<int>(order.size())};
  for (const std::uint16_t group : groups) rows.row_of_point.push_back(row_of_group[group]);
  return rows;
}

/// True if nearly all values ascend, or descend, and none jumps back over half of them.
bool runs_one_way(const std::vector<double>& values) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  const double sign = values.back() > values.front() ? 1 : -1;
  std::size_t back = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = sign * (values[i] - values[i - 1]);
    if (step < -0.5 * (*greatest - *least)) return false;
    back += step < 0 ? 1 : 0;
  }
  return back * 10 <= values.size() - 1;
}

/// A laser's turn ends where the azimuth jumps over the whole turn. Holds if nearly all jumps have one direction, and
/// the turns' elevations ascend or descend.
std::optional<SweepRows> rows_by_order(const std::vector<Vector3f>& points) {
  std::vector<std::uint16_t> groups;
  std::size_t falls = 0, rises = 0, turn = 0, in_turn = 0;
  double before = azimuth_of(points.front());
  for (const Vector3f& p : points) {
    const double azimuth = azimuth_of(p);
    const double jump = azimuth - before;
    before = azimuth;
    // A few points back and forth over the seam, as undone motion leaves them, are one jump.
    if (std::abs(jump) > kFullTurn / 2 && in_turn >= kFewestInRow) {
      ++(jump < 0 ? falls : rises);
      ++turn;
      in_turn = 0;
    }
    if (turn >= kMostRows) return std::nullopt;
    ++in_turn;
    groups.push_back(static_cast<std::uint16_t>(turn));
  }
  constexpr std::size_t kFewestTurns = 4;
  if (turn + 1 < kFewestTurns || std::min(falls, rises) * 5 > std::max(falls, rises)) return std::nullopt;
  std::vector<std::vector<double>> elevations(turn + 1);
  for (std::size_t i = 0; i < points.size(); ++i) elevations[groups[i]].push_back(elevation_of(points[i]));
  std::vector<double> middles;
  for (auto& of_turn : elevations) middles.push_back(median(std::move(of_turn)));
  return runs_one_way(middles) ? std::optional(rows_from_groups(points, groups, SweepRows::Kind::kOrder))
                               : std::nullopt;
}

/// Lasers have elevations with gaps between them.
std::optional<SweepRows> rows_by_elevation(const std::vector<Vector3f>& points) {
  constexpr double kGap = 0.05 * kDegree, kWidest = 0.3 * kDegree;
  constexpr std::size_t kFewestRows = 4;
  std::vector<double> elevations;
  for (const Vector3f& p : points) elevations.push_back(elevation_of(p));
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return elevations[a] < elevations[b]; });
  std::vector<std::uint16_t> groups(points.size());
  std::size_t group = 0;
  std::size_t crowded = 0, in_group = 0;
  double first = elevations[order.front()], last = first;  // of the group
  const auto close_group = [&] {
    const bool is_laser = in_group >= kFewestInRow && last - first < kWidest;
    crowded += is_laser ? in_group : 0;
  };
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k > 0 && elevations[order[k]] - elevations[order[k - 1]] > kGap) {
      close_group();
      ++group;
      in_group = 0;
      first = elevations[order[k]];
      if (group >= kMostRows) return std::nullopt;
    }
    ++in_group;
    last = elevations[order[k]];
    groups[order[k]] = static_cast<std::uint16_t>(group);
  }
  close_group();
  if (group + 1 < kFewestRows || crowded * 10 < points.size() * 9) return std::nullopt;
  return rows_from_groups(points, groups, SweepRows::Kind::kElevations);
}

SweepRows uniform_rows(const std::vector<Vector3f>& points) {
  std::vector<std::uint16_t> groups;
  for (const Vector3f& p : points) {
    const double step = (elevation_of(p) + kFullTurn / 4) / (SweepRows::kUniformStep_deg * kDegree);
    groups.push_back(static_cast<std::uint16_t>(step));  // 0 to 450
  }
  return rows_from_groups(points, groups, SweepRows::Kind::kUniform);
}

/// The usual difference of azimuth between neighbours of a row.
double azimuth_step(const std::vector<Vector3f>& points, const SweepRows& rows) {
  std::vector<std::vector<double>> azimuths(static_cast<std::size_t>(rows.rows));
  for (std::size_t i = 0; i < points.size(); ++i) azimuths[rows.row_of_point[i]].push_back(azimuth_of(points[i]));
  constexpr double kFinest = 0.005 * kDegree;  // nearer points are returns of one shot
  std::vector<double> steps;
  for (auto& row : azimuths) {
    std::sort(row.begin(), row.end());
    for (std::size_t i = 1; i < row.size(); ++i) {
      if (row[i] - row[i - 1] > kFinest) steps.push_back(row[i] - row[i - 1]);
    }
  }
  return median(std::move(steps));
}

}  // namespace

SweepRows find_rows(const Sweep& sweep) {
  if (sweep.points_m.empty()) return {};
  if (sweep.rings.size() == sweep.points_m.size()) {
    const bool is_sound = *std::max_element(sweep.rings.begin(), sweep.rings.end()) < kMostRows;
    if (is_sound) return rows_from_groups(sweep.points_m, sweep.rings, SweepRows::Kind::kRings);
  }
  if (auto rows = rows_by_order(sweep.points_m)) return *std::move(rows);
  if (auto rows = rows_by_elevation(sweep.points_m)) return *std::move(rows);
  return uniform_rows(sweep.points_m);
}

RangeScan grid_of(const Sweep& sweep, const SweepRange& range) {
  RangeScan scan;
  scan.sight = {.kind = SightLines::Kind::kSphere, .pole = 2};
  scan.T_world_scan = sweep.T_world_sensor;
  const SweepRows rows = find_rows(sweep);
  if (rows.rows == 0) return scan;
  // A little wider than the points' own steps, so that hardly a cell between them stays empty.
  constexpr double kWider = 1.25;
  constexpr int kMostColumns = 8192, kFewestColumns = 64;
  const double step = kWider * azimuth_step(sweep.points_m, rows);
  const int columns = step > 0
                          ? static_cast<int>(std::clamp(kFullTurn / step, double{kFewestColumns}, double{kMostColumns}))
                          : kFewestColumns;
  scan.points_m = Image<Vector3f>(columns + 1, rows.rows, kNoReturn);
  for (std::size_t i = 0; i < sweep.points_m.size(); ++i) {
    const Vector3f& p = sweep.points_m[i];
    const auto distance = static_cast<double>(p.norm());
    if (distance < range.min_m || (range.max_m > 0 && distance > range.max_m)) continue;
    // Azimuths run counter-clockwise, columns clockwise: as a picture from the sensor.
    const int column = columns - 1 - std::min(columns - 1, static_cast<int>(azimuth_of(p) / kFullTurn * columns));
    Vector3f& cell = scan.points_m.at(column, rows.row_of_point[i]);
    if (!has_return(cell) || p.norm() < cell.norm()) cell = p;
  }
  for (int y = 0; y < rows.rows; ++y) scan.points_m.at(columns, y) = scan.points_m.at(0, y);
  return scan;
}

}  // namespace scanknit
