#include "export/report/page_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostColumns = 300;  // a pixel or two each on a phone
constexpr std::size_t kMostPoses = 600;

constexpr std::array<std::string_view, 4> kStates = {"ok", "recovered", "weak", "lost"};  // from good to bad

/// The worst of the frames that share a column of the chart.
struct Column {
  double overlap = 1, inlier_share = 1;
  std::size_t state = 0;  ///< place in kStates
};

std::size_t state_of(std::string_view word) {
  const auto found = std::find(kStates.begin(), kStates.end(), word);
  return found == kStates.end() ? 0 : static_cast<std::size_t>(found - kStates.begin());
}

std::vector<Column> columns_of(std::span<const TrackedFrameShares> frames) {
  const std::size_t count = std::min(frames.size(), kMostColumns);
  std::vector<Column> columns(count);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Column& column = columns[i * count / frames.size()];
    // The first frame is compared with nothing.
    if (i > 0) {
      column.overlap = std::min(column.overlap, frames[i].overlap);
      column.inlier_share = std::min(column.inlier_share, frames[i].inlier_share);
    }
    column.state = std::max(column.state, state_of(frames[i].state));
  }
  return columns;
}

std::string points_of(const std::vector<Column>& columns, double Column::*value) {
  std::string points;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double share = std::clamp(columns[i].*value, 0.0, 1.0);
    points += fmt::format("{:.1f},{:.1f} ", static_cast<double>(i) + 0.5, 100 - 100 * share);
  }
  return points;
}

}  // namespace

TrackingChart tracking_chart(std::span<const TrackedFrameShares> frames) {
  const std::vector<Column> columns = columns_of(frames);
  TrackingChart chart{{}, points_of(columns, &Column::overlap), points_of(columns, &Column::inlier_share)};
  for (const Column& column : columns) chart.states.push_back(kStates[column.state]);
  return chart;
}

std::vector<Eigen::Vector3d> camera_positions(std::string_view trajectory) {
  std::vector<Eigen::Vector3d> positions;
  while (!trajectory.empty()) {
    std::string_view line = take_line(trajectory);
    std::array<double, 4> numbers{};  // stamp, x, y, z
    std::size_t count = 0;
    for (; count < numbers.size(); ++count) {
      const auto value = parse_double(take_word(line));
      if (!value || !std::isfinite(*value)) break;
      numbers[count] = *value;
    }
    if (count == numbers.size()) positions.emplace_back(numbers[1], numbers[2], numbers[3]);
  }
  if (positions.size() <= kMostPoses) return positions;
  std::vector<Eigen::Vector3d> fewer;
  for (std::size_t i = 0; i < kMostPoses; ++i) {
    fewer.push_back(positions[i * (positions.size() - 1) / (kMostPoses - 1)]);
  }
  return fewer;
}

PathDrawing draw_path(const std::vector<Eigen::Vector3d>& positions, const Eigen::AlignedBox3d& mesh, int right,
                      int down) {
  Eigen::AlignedBox2d all;
  for (const Eigen::Vector3d& p : positions) all.extend(Eigen::Vector2d(p[right], p[down]));
  if (!mesh.isEmpty()) {
    all.extend(Eigen::Vector2d(mesh.min()[right], mesh.min()[down]));
    all.extend(Eigen::Vector2d(mesh.max()[right], mesh.max()[down]));
  }
  PathDrawing drawing;
  const double side = drawing.side_m = std::max(1e-6, 1.1 * all.sizes().maxCoeff());
  const Eigen::Vector2d corner = all.center() - Eigen::Vector2d::Constant(side / 2);
  const auto place = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(100 * (p[right] - corner[0]) / side, 100 * (p[down] - corner[1]) / side);
  };
  if (!mesh.isEmpty()) {
    const Eigen::Vector2d low = place(mesh.min());
    drawing.mesh = {low.x(), low.y(), 100 * mesh.sizes()[right] / side, 100 * mesh.sizes()[down] / side};
  }
  for (const Eigen::Vector3d& p : positions) {
    drawing.points += fmt::format("{:.2f},{:.2f} ", place(p).x(), place(p).y());
  }
  drawing.first = place(positions.front());
  drawing.last = place(positions.back());
  return drawing;
}

}  // namespace scanknit
