#include "calibrate/print/target_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scanknit {
namespace {

constexpr double kMargin_m = 0.010;  // no printer prints up to the edge
constexpr double kLeft_m = 0.008;    // for the upright line
constexpr double kBelow_m = 0.020;   // for the text and the level line
constexpr double kLine_m = 0.100;
constexpr double kThin_m = 0.0003;

Eigen::Vector2d sheet_m(Paper paper, bool is_across) {
  const Eigen::Vector2d upright = paper == Paper::kA4   ? Eigen::Vector2d(0.210, 0.297)
                                  : paper == Paper::kA3 ? Eigen::Vector2d(0.297, 0.420)
                                                        : Eigen::Vector2d(0.2159, 0.2794);
  return is_across ? Eigen::Vector2d(upright.y(), upright.x()) : upright;
}

/// Room for the board.
Eigen::Vector2d room_m(const Eigen::Vector2d& sheet) {
  return sheet - Eigen::Vector2d(2 * kMargin_m + kLeft_m, 2 * kMargin_m + kBelow_m);
}

bool lies_across(const CalibrationTarget& target) {
  return extent_m(target).x() > extent_m(target).y();
}

/// A line of 100 mm with a bar at each end. The bars' outer edges are the measure.
void add_measure(const Eigen::Vector2d& begin, bool is_upright, VectorPage& page) {
  constexpr double kBar_m = 0.004;
  const auto add = [&](double along, double across, double length, double width) {
    const Eigen::Vector2d at = is_upright ? Eigen::Vector2d(across, along) : Eigen::Vector2d(along, across);
    const Eigen::Vector2d size = is_upright ? Eigen::Vector2d(width, length) : Eigen::Vector2d(length, width);
    page.rectangles.push_back({begin + at, size});
  };
  add(0, 0, kThin_m, kBar_m);
  add(kLine_m - kThin_m, 0, kThin_m, kBar_m);
  add(kThin_m, (kBar_m - kThin_m) / 2, kLine_m - 2 * kThin_m, kThin_m);
}

void add_text(const Eigen::Vector2d& at, double height_m, std::string text, VectorPage& page) {
  PageText& added = page.texts.emplace_back();
  added.baseline_m = at;
  added.height_m = height_m;
  added.text = std::move(text);
}

void add_texts(const CalibrationTarget& target, VectorPage& page) {
  constexpr double kLarge_m = 0.0032, kSmall_m = 0.0028;
  const double left = kMargin_m + kLeft_m;
  const double top = page.size_m.y() - kMargin_m - kBelow_m;
  const double size_mm = 1000 * target.size_m;
  const bool is_grid = target.type == TargetType::kAprilGrid;
  add_text({left, top + 0.005}, kLarge_m,
           fmt::format("ScanKnit target: {}, {} x {} {}, {:.6g} mm each; tags 36h11 from 0",
                       is_grid ? "aprilgrid" : "charuco", target.columns, target.rows, is_grid ? "tags" : "squares",
                       size_mm),
           page);
  add_text({left, top + 0.009}, kSmall_m,
           "Print in actual size (100 %), glue it to a flat plate. Both lines must measure 100.0 mm over", page);
  add_text(
      {left, top + 0.0125}, kSmall_m,
      fmt::format("their ends. If both measure M mm, write M / 100 x {:.6g} mm as size in target.yaml; if they differ, "
                  "print again.",
                  size_mm),
      page);
  add_text({left + kLine_m + 0.002, top + 0.0185}, kSmall_m, "100 mm", page);
  add_text({kMargin_m + 0.003, kMargin_m + kLine_m + 0.014}, kSmall_m, "100 mm", page);
  page.texts.back().is_upwards = true;
}

}  // namespace

std::optional<double> largest_size_m(const CalibrationTarget& target, Paper paper) {
  CalibrationTarget unit = target;
  unit.size_m = 1;
  const Eigen::Vector2d room = room_m(sheet_m(paper, lies_across(unit)));
  const double largest = (room.array() / extent_m(unit).array()).minCoeff();
  const double whole = std::floor(1000 * largest + 1e-9) / 1000;
  return whole >= 0.001 ? std::optional(whole) : std::nullopt;
}

Result<VectorPage> target_page(const CalibrationTarget& target, Paper paper) {
  VectorPage page;
  page.size_m = sheet_m(paper, lies_across(target));
  const Eigen::Vector2d room = room_m(page.size_m);
  const Eigen::Vector2d extent = extent_m(target);
  if ((extent.array() > room.array() + 1e-9).any()) {
    const auto largest = largest_size_m(target, paper);
    return Error{ErrorCode::kUsage,
                 fmt::format("the board is {:.0f} x {:.0f} mm, but the paper has room for {:.0f} x {:.0f} mm; {}",
                             1000 * extent.x(), 1000 * extent.y(), 1000 * room.x(), 1000 * room.y(),
                             largest ? fmt::format("the largest --size that fits is {:.0f} mm", 1000 * *largest)
                                     : "take fewer columns and rows")};
  }
  auto shapes = target_shapes(target);
  if (!shapes) return shapes.error();
  page.rectangles = *std::move(shapes);
  const Eigen::Vector2d corner = Eigen::Vector2d(kMargin_m + kLeft_m, kMargin_m) + (room - extent) / 2;
  for (BlackRectangle& shape : page.rectangles) shape.corner_m += corner;
  add_measure({kMargin_m, kMargin_m}, true, page);
  add_measure({kMargin_m + kLeft_m, page.size_m.y() - kMargin_m - 0.005}, false, page);
  add_texts(target, page);
  return page;
}

}  // namespace scanknit
