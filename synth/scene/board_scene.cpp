#include "synth/scene/board_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "calibrate/print/target_shapes.h"
#include "synth/scene/analytic_scene.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/drawing.h"
#include "synth/scene/scene_names.h"

namespace scanknit {
namespace {

constexpr double kHeight_m = 1.2;       // of the board's middle above the floor
constexpr double kHalfThick_m = 0.003;  // of the plate that the board is glued to
constexpr double kBorder_m = 0.03;      // white round what is black

/// What is black on the board, as a real camera sees it: a renderer's ray has no width, but ink spreads and a pixel is
/// the mean of what it covers.
class Print {
 public:
  Print(const CalibrationTarget& target, const std::vector<BlackRectangle>& shapes)
      : cell_m_(target.size_m / kTagCells),
        low_m_(Eigen::Vector2d::Constant(-kSpot_m)),
        columns_(count(extent_m(target).x())),
        rows_(count(extent_m(target).y())) {
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(kSpot_m / 2);
    for (const BlackRectangle& shape : shapes) {
      const Eigen::Vector2i first = cell_of(shape.corner_m - reach);
      const Eigen::Vector2i last = cell_of(shape.corner_m + shape.size_m + reach);
      for (int y = first.y(); y <= last.y(); ++y) {
        for (int x = first.x(); x <= last.x(); ++x) cells_[place_of({x, y})].push_back(shape);
      }
    }
  }

  /// The share of black in a spot round a point of the board's frame.
  [[nodiscard]] double blackness(const Eigen::Vector2d& at) const {
    const Eigen::Vector2i cell = cell_of(at);
    if (cell.x() < 0 || cell.y() < 0 || cell.x() >= columns_ || cell.y() >= rows_) return 0;
    const Eigen::Array2d low = at.array() - kSpot_m / 2;
    double area = 0;
    for (const BlackRectangle& shape : cells_[place_of(cell)]) {
      const Eigen::Array2d begin = low.max(shape.corner_m.array());
      const Eigen::Array2d end = (low + kSpot_m).min((shape.corner_m + shape.size_m).array());
      area += (end - begin).max(0.0).prod();
    }
    return std::min(1.0, area / (kSpot_m * kSpot_m));
  }

 private:
  static constexpr double kSpot_m = 0.0012;  // a pixel of a camera of 525 pixels focal length at 0.63 m

  [[nodiscard]] int count(double extent) const { return static_cast<int>((extent + 2 * kSpot_m) / cell_m_) + 1; }
  [[nodiscard]] Eigen::Vector2i cell_of(const Eigen::Vector2d& at) const {
    return ((at - low_m_) / cell_m_).array().floor().cast<int>();
  }
  [[nodiscard]] std::size_t place_of(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(cell.x());
  }

  double cell_m_;
  Eigen::Vector2d low_m_;
  int columns_, rows_;
  std::vector<std::vector<BlackRectangle>> cells_;  ///< the shapes that a spot in each cell of a grid may touch
};

/// Some solids, the first of which has a board on its front.
class BoardScene final : public SyntheticScene {
 public:
  BoardScene(std::unique_ptr<SyntheticScene> solids, Print print, const Pose& T_world_board)
      : SyntheticScene(solids->name(), solids->path(), solids->default_frames()),
        solids_(std::move(solids)),
        print_(std::move(print)),
        T_board_world_(T_world_board.inverse()) {}

  [[nodiscard]] std::optional<double> intersect(const Ray& ray, double max_t_m) const override {
    return solids_->intersect(ray, max_t_m);
  }
  [[nodiscard]] double distance(const Eigen::Vector3d& p_world) const override { return solids_->distance(p_world); }
  [[nodiscard]] SurfacePoint nearest(const Eigen::Vector3d& p_world) const override {
    return solids_->nearest(p_world);
  }
  [[nodiscard]] Eigen::AlignedBox3d bounds() const override { return solids_->bounds(); }

  // Light goes with the square of sRGB, as in blurred() (sensor/sense_colour.h).
  [[nodiscard]] Eigen::Vector3d colour(const SurfacePoint& point) const override {
    constexpr double kInk = 0.08, kPaper = 0.90;  // neither is clipped where noise is added
    if (point.part != 0) return solids_->colour(point);
    const bool is_front = (T_board_world_.linear() * point.normal).z() < -0.5;
    const double black = is_front ? print_.blackness((T_board_world_ * point.position).head<2>()) : 0;
    return Eigen::Vector3d::Constant(std::sqrt(kPaper * kPaper + black * (kInk * kInk - kPaper * kPaper)));
  }

 private:
  std::unique_ptr<SyntheticScene> solids_;
  Print print_;
  Pose T_board_world_;
};

/// From the front, up to 40 degrees to each side and 35 up and down, 0.45 to 0.8 m away. The board goes to all borders
/// of the picture and is turned in it, as by a hand that is in no hurry.
CameraPath path_before_board() {
  return [](double s) {
    constexpr double kTurn = 2 * std::numbers::pi, kDegree = std::numbers::pi / 180;
    const double azimuth = 40 * kDegree * std::sin(kTurn * 2 * s);
    const double elevation = 35 * kDegree * std::sin(kTurn * 3 * s + 1);
    const double away_m = 0.625 + 0.175 * std::cos(kTurn * 2.5 * s);
    const Eigen::Vector3d board(0, 0, kHeight_m);
    const Eigen::Vector3d direction(std::sin(azimuth) * std::cos(elevation), -std::cos(azimuth) * std::cos(elevation),
                                    std::sin(elevation));
    const Eigen::Vector3d gaze(0.17 * std::sin(kTurn * 4 * s + 2), 0, 0.12 * std::sin(kTurn * 5 * s));
    return Pose(look_at(board + away_m * direction, board + gaze) *
                Eigen::AngleAxisd(30 * kDegree * std::sin(kTurn * s), Eigen::Vector3d::UnitZ()));
  };
}

}  // namespace

Result<std::unique_ptr<SyntheticScene>> board_scene() {
  constexpr int kFrames = 300;
  const auto shapes = target_shapes(kSceneBoard);
  if (!shapes) return shapes.error();
  const Eigen::Vector2d extent = extent_m(kSceneBoard);
  Drawing drawing;  // the board first
  drawing.add(Box{{extent.x() / 2 + kBorder_m, kHalfThick_m, extent.y() / 2 + kBorder_m}}, {0, kHalfThick_m, kHeight_m},
              bare(80));
  drawing.add_room({3.6, 4.0, 2.4}, paint(81, Pattern::kMarble, 0.2));
  drawing.stand_box(0.7, 0.9, 0, {0.6, 0.5, 0.9}, paint(82, Pattern::kStripes, 0.1), 20);
  drawing.stand_box(-0.8, 1.2, 0, {0.5, 0.4, 1.6}, paint(83, Pattern::kChecks, 0.15), -10);
  Pose T_world_board = Pose::Identity();
  T_world_board.translation() =
      T_world_plan() * Eigen::Vector3d(0, 0, kHeight_m) - Eigen::Vector3d(extent.x() / 2, extent.y() / 2, 0);
  auto solids = std::move(drawing).scene(std::string(kBoardSceneName), path_before_board(), kFrames);
  return std::unique_ptr<SyntheticScene>(
      std::make_unique<BoardScene>(std::move(solids), Print(kSceneBoard, *shapes), T_world_board));
}

}  // namespace scanknit
