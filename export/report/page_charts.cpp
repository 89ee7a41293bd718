#include "export/report/page_charts.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostColumns = 300;  // a pixel or two each on a phone
constexpr std::size_t kMostPoses = 600;

/// Frames that share a column of the chart: the worst of them is drawn.
struct Column {
  double overlap = 1, inlier_share = 1;
  int state = 0;  ///< place in kStates
};

// From good to bad.
constexpr std::array<std::string_view, 4> kStates = {"ok", "recovered", "weak", "lost"};

int state_of(const std::string& word) {
  const auto found = std::find(kStates.begin(), kStates.end(), word);
  return found == kStates.end() ? 0 : static_cast<int>(found - kStates.begin());
}

std::vector<Column> columns_of(const PageJson& frames) {
  const std::size_t count = std::min(frames.size(), kMostColumns);
  std::vector<Column> columns(count);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Column& column = columns[i * count / frames.size()];
    // The first frame is compared with nothing.
    if (i > 0) {
      column.overlap = std::min(column.overlap, number_at(frames[i], "/overlap").value_or(0));
      column.inlier_share = std::min(column.inlier_share, number_at(frames[i], "/inlier_share").value_or(0));
    }
    column.state = std::max(column.state, state_of(text_at(frames[i], "/state")));
  }
  return columns;
}

std::string polyline(const std::vector<Column>& columns, double Column::*value, const char* css_class) {
  std::string points;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double share = std::clamp(columns[i].*value, 0.0, 1.0);
    points += fmt::format("{:.1f},{:.1f} ", static_cast<double>(i) + 0.5, 100 - 100 * share);
  }
  return fmt::format("<polyline class=\"{}\" points=\"{}\"/>", css_class, points);
}

std::vector<Eigen::Vector3d> positions_of(std::string_view trajectory) {
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

/// Four rows of four; the identity when it is not that.
Eigen::Affine3d affine_of(const PageJson& rows) {
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  if (!rows.is_array() || rows.size() != 4) return T;
  for (std::size_t row = 0; row < 3; ++row) {
    if (!rows[row].is_array() || rows[row].size() != 4) return Eigen::Affine3d::Identity();
    for (std::size_t column = 0; column < 4; ++column) {
      if (!rows[row][column].is_number()) return Eigen::Affine3d::Identity();
      T(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = rows[row][column].as_number();
    }
  }
  return T.matrix().allFinite() ? T : Eigen::Affine3d::Identity();
}

Eigen::AlignedBox3d box_of(const PageJson& bounds_m) {
  Eigen::AlignedBox3d box;
  if (!bounds_m.is_array() || bounds_m.size() != 2) return box;
  for (std::size_t end = 0; end < 2; ++end) {
    const PageJson corner = bounds_m[end];
    if (!corner.is_array() || corner.size() != 3) return {};
    Eigen::Vector3d p;
    for (std::size_t i = 0; i < 3; ++i) {
      if (!corner[i].is_number()) return {};
      p[static_cast<Eigen::Index>(i)] = corner[i].as_number();
    }
    if (p.allFinite()) box.extend(p);
  }
  return box;
}

/// Seen along the third axis; `right` and `down` are places of coordinates.
std::string path_from_one_side(const std::vector<Eigen::Vector3d>& positions, const Eigen::AlignedBox3d& mesh,
                               int right, int down, const char* words) {
  Eigen::AlignedBox2d all;
  for (const Eigen::Vector3d& p : positions) all.extend(Eigen::Vector2d(p[right], p[down]));
  if (!mesh.isEmpty()) {
    all.extend(Eigen::Vector2d(mesh.min()[right], mesh.min()[down]));
    all.extend(Eigen::Vector2d(mesh.max()[right], mesh.max()[down]));
  }
  const double side = std::max(1e-6, 1.1 * all.sizes().maxCoeff());
  const Eigen::Vector2d corner = all.center() - Eigen::Vector2d::Constant(side / 2);
  const auto place = [&](double metres, int axis) { return 100 * (metres - corner[axis]) / side; };
  std::string svg = "<figure><svg viewBox=\"0 0 100 100\" role=\"img\">";
  if (!mesh.isEmpty()) {
    svg += fmt::format("<rect class=\"box\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>",
                       place(mesh.min()[right], 0), place(mesh.min()[down], 1), 100 * mesh.sizes()[right] / side,
                       100 * mesh.sizes()[down] / side);
  }
  svg += "<polyline class=\"path\" points=\"";
  for (const Eigen::Vector3d& p : positions) {
    svg += fmt::format("{:.2f},{:.2f} ", place(p[right], 0), place(p[down], 1));
  }
  svg += "\"/>";
  const auto dot = [&](const Eigen::Vector3d& p, const char* css_class) {
    return fmt::format("<circle class=\"{}\" cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"2\"/>", css_class, place(p[right], 0),
                       place(p[down], 1));
  };
  svg += dot(positions.front(), "first") + dot(positions.back(), "last") + "</svg>";
  return svg + fmt::format("<figcaption>{}; the square is {} wide</figcaption></figure>\n", words, length_words(side));
}

}  // namespace

std::string tracking_chart(const PageJson& frames) {
  if (!frames.is_array() || frames.empty()) return "";
  const std::vector<Column> columns = columns_of(frames);
  std::string svg = fmt::format(
      "<svg class=\"chart\" viewBox=\"0 0 {0} 112\" preserveAspectRatio=\"none\" role=\"img\">"
      "<path class=\"grid\" d=\"M0 0H{0} M0 50H{0} M0 100H{0}\"/>",
      columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto state = static_cast<std::size_t>(columns[i].state);
    svg += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"104\" width=\"1.05\" height=\"8\"/>", kStates[state], i);
  }
  svg +=
      polyline(columns, &Column::overlap, "overlap") + polyline(columns, &Column::inlier_share, "inliers") + "</svg>";
  const auto number_of = [&](std::size_t i) {
    return grouped_digits(number_at(frames[i], "/frame").value_or(static_cast<double>(i)));
  };
  return "<div class=\"axis\"><span>100 %</span></div>" + svg +
         fmt::format("<div class=\"axis\"><span>frame {}</span><span>frame {}</span></div>", number_of(0),
                     number_of(frames.size() - 1)) +
         "<p class=\"legend\"><i class=\"overlap\"></i>overlap with the model <i class=\"inliers\"></i>share of points "
         "that fit it <i class=\"ok\"></i>ok <i class=\"recovered\"></i>recovered <i class=\"weak\"></i>weak "
         "<i class=\"lost\"></i>lost</p>\n";
}

std::string camera_path(std::string_view trajectory, const PageJson& T_mesh_world, const PageJson& bounds_m) {
  std::vector<Eigen::Vector3d> positions = positions_of(trajectory);
  if (positions.size() < 2) return "";
  const Eigen::Affine3d T = affine_of(T_mesh_world);
  for (Eigen::Vector3d& position : positions) position = T * position;
  const Eigen::AlignedBox3d mesh = box_of(bounds_m);
  return "<div class=\"pair\">\n" + path_from_one_side(positions, mesh, 0, 2, "x to the right, z downwards") +
         path_from_one_side(positions, mesh, 0, 1, "x to the right, y downwards") +
         "</div>\n<p class=\"legend\"><i class=\"first\"></i>first pose <i class=\"last\"></i>last pose; the box is "
         "the "
         "mesh's</p>\n";
}

std::string stage_bars(const PageJson& stages) {
  struct Stage {
    std::string name;
    double total_ms, median_ms, p95_ms;
  };
  std::vector<Stage> used;
  if (!stages.is_object()) return "";
  for (const auto& [name, times] : stages.items()) {
    const double total_ms = number_at(times, "/total_ms").value_or(0);
    if (total_ms > 0) {
      used.push_back(
          {name, total_ms, number_at(times, "/median_ms").value_or(0), number_at(times, "/p95_ms").value_or(0)});
    }
  }
  if (used.empty()) return "";
  std::stable_sort(used.begin(), used.end(), [](const Stage& a, const Stage& b) { return a.total_ms > b.total_ms; });
  std::vector<std::vector<std::string>> rows;
  for (const Stage& stage : used) {
    const std::string bar =
        fmt::format("<b class=\"bar\" style=\"width:{:.1f}%\"></b>", 100 * stage.total_ms / used.front().total_ms);
    rows.push_back({escaped(stage.name), time_words(stage.total_ms) + bar, fmt::format("{:.2f} ms", stage.median_ms),
                    fmt::format("{:.2f} ms", stage.p95_ms)});
  }
  return table({"stage", "total", "median of a call", "95 %"}, rows);
}

}  // namespace scanknit
