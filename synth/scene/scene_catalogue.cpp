#include <array>
#include <cmath>

#include "core/rotation.h"
#include "synth/scene/board_scene.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/drawing.h"
#include "synth/scene/real_rooms.h"
#include "synth/scene/scene_names.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

std::unique_ptr<SyntheticScene> sphere() {
  Drawing drawing;
  drawing.add(Sphere{0.1}, Vector3d::Zero(), paint(0, Pattern::kChecks, 0.025));
  return std::move(drawing).scene("sphere", turntable_path({}), 120);
}

// Nothing is thinner than 2 cm: thin plates are in the scene `plates`. Base, body, head and spout are topological
// balls, joined as a tree; the handle closes one loop: genus 1.
std::unique_ptr<SyntheticScene> turntable() {
  Drawing drawing;
  drawing.add(Cylinder{0.062, 0.014, 0.006}, {0, 0, -0.098}, paint(0, Pattern::kStripes, 0.010));
  drawing.add(Box{{0.038, 0.034, 0.062}, 0.014}, {0, 0, -0.030}, paint(1, Pattern::kChecks, 0.012), Drawing::yaw(10));
  drawing.add(Sphere{0.040}, {0, 0, 0.058}, paint(2, Pattern::kMarble, 0.010));
  drawing.add(frustum(0.024, 0.010, 0.050), {0, 0, 0.112}, paint(5, Pattern::kStripes, 0.006));
  drawing.add(Torus{0.034, 0.0125}, {0.052, 0.009, -0.026}, paint(3, Pattern::kChecks, 0.008),
              Drawing::yaw(10) * Drawing::roll(90));
  drawing.add(Cylinder{0.016, 0.045, 0.006}, {-0.055, -0.010, -0.010}, paint(4, Pattern::kStripes, 0.008),
              Drawing::yaw(10) * Eigen::AngleAxisd(-65 * kDegree, Vector3d::UnitY()).toRotationMatrix());
  return std::move(drawing).scene("turntable", turntable_path({}), 300);
}

// During one turn, a camera 28 degrees above sees the whole surface except the underside. No two sides look the same.
// The parts are topological balls, joined as a chain.
std::unique_ptr<SyntheticScene> tower() {
  Drawing drawing;
  drawing.add(Box{{0.060, 0.050, 0.030}, 0.008}, {0, 0, -0.070}, paint(0, Pattern::kStripes, 0.012), Drawing::yaw(5));
  drawing.add(frustum(0.046, 0.036, 0.070), {-0.010, 0.002, -0.007}, paint(3, Pattern::kChecks, 0.012));
  drawing.add(Box{{0.020, 0.022, 0.045}, 0.008}, {0.030, -0.010, -0.002}, paint(1, Pattern::kMarble, 0.012),
              Drawing::yaw(25));
  drawing.add(Box{{0.026, 0.020, 0.034}, 0.010}, {-0.012, 0.002, 0.058}, paint(2, Pattern::kChecks, 0.010),
              Drawing::yaw(-15));
  return std::move(drawing).scene("tower", turntable_path({}), 300);
}

/// The wall is 1 cm thick, and the handle's tube, too, which ends within the wall.
std::unique_ptr<SyntheticScene> cup() {
  constexpr double kHalfHeight_m = 0.05, kOuter_m = 0.038, kInner_m = 0.028, kInnerFloor_m = -0.038;
  const Lathe body{{{0, -kHalfHeight_m},
                    {kOuter_m, -kHalfHeight_m},
                    {kOuter_m, kHalfHeight_m},
                    {kInner_m, kHalfHeight_m},
                    {kInner_m, kInnerFloor_m},
                    {0, kInnerFloor_m}}};
  Drawing drawing;
  drawing.add(body, {0, 0, 0}, paint(0, Pattern::kChecks, 0.012));
  drawing.add(Torus{0.024, 0.005}, {0.058, 0, 0}, paint(3, Pattern::kStripes, 0.008), Drawing::roll(90));
  drawing.made_of({.reflectivity = 0, .gloss = 0});
  return std::move(drawing).scene("cup", turntable_path({.distance_m = 0.4}), 120);
}

void put_desk(Drawing& drawing, double top_m) {
  drawing.add(Box{{0.5, 0.3, 0.015}, 0.004}, {0, 0, top_m - 0.015}, paint(7, Pattern::kMarble, 0.05));
  for (const double x : {-0.45, 0.45}) {
    for (const double y : {-0.25, 0.25}) {
      drawing.stand_box(x, y, 0, {0.05, 0.05, top_m - 0.02}, paint(8, Pattern::kStripes, 0.04));
    }
  }
}

void put_things_on_desk(Drawing& drawing, double top_m) {
  drawing.stand_cylinder(-0.15, -0.12, top_m, 0.042, 0.10, paint(0, Pattern::kStripes, 0.012));  // a mug
  drawing.add(Torus{0.030, 0.006}, {-0.195, -0.12, top_m + 0.055}, paint(0, Pattern::kChecks, 0.010),
              Drawing::roll(90));
  drawing.add(vase(), {0.20, 0.12, top_m + 0.11 - kSunk_m}, paint(2, Pattern::kMarble, 0.02));
  drawing.add(Sphere{0.06}, {0.06, -0.14, top_m + 0.06 - kSunk_m}, paint(3, Pattern::kChecks, 0.02));
  drawing.stand_box(-0.32, 0.08, top_m, {0.16, 0.22, 0.03}, paint(4, Pattern::kStripes, 0.02), 20, 0.002);
  drawing.stand_box(-0.31, 0.09, top_m + 0.03, {0.13, 0.19, 0.025}, paint(5, Pattern::kChecks, 0.02), 35, 0.002);
  drawing.add(Torus{0.05, 0.018}, {0.33, -0.13, top_m + 0.018 - kSunk_m}, paint(6, Pattern::kStripes, 0.02));
  drawing.add(frustum(0.05, 0.0, 0.15), {0.0, 0.10, top_m + 0.075 - kSunk_m}, paint(9, Pattern::kChecks, 0.015));
  drawing.stand_box(0.42, 0.14, top_m, {0.08, 0.12, 0.20}, paint(10, Pattern::kChecks, 0.02), -15, 0.010);
}

std::unique_ptr<SyntheticScene> desk() {
  constexpr double kDeskTop_m = 0.74;
  Drawing drawing;
  drawing.add_room({3.4, 3.2, 2.4}, paint(12, Pattern::kChecks, 0.12));
  put_desk(drawing, kDeskTop_m);
  put_things_on_desk(drawing, kDeskTop_m);
  drawing.stand_box(1.50, 0.3, 0, {0.44, 0.9, 0.8}, paint(13, Pattern::kStripes, 0.07));
  drawing.stand_box(-0.6, 1.45, 0, {1.0, 0.36, 1.3}, paint(14, Pattern::kChecks, 0.09));
  drawing.stand_cylinder(-1.4, -1.2, 0, 0.18, 0.6, paint(15, Pattern::kStripes, 0.06));
  drawing.add(Box{{0.4, 0.02, 0.3}, 0.004}, {0.4, -1.6, 1.0}, paint(16, Pattern::kMarble, 0.06));
  // 5 cm a frame at 3 degrees: radius 0.955 m.
  const OrbitPath path{{0, 0, kDeskTop_m + 0.05}, 1.30, 0.955, 0.955, 1};
  return std::move(drawing).scene("desk", orbit_path(path), 120);
}

std::unique_ptr<SyntheticScene> plates() {
  constexpr double kPlinth_m = 0.4;
  constexpr std::array kThickness_m = {0.006, 0.008, 0.010, 0.012, 0.016, 0.020};
  Drawing drawing;
  drawing.add_room({6.0, 6.0, 2.6}, paint(20, Pattern::kChecks, 0.15));
  drawing.stand_cylinder(0, 0, 0, 0.45, kPlinth_m, paint(21, Pattern::kMarble, 0.05));
  for (std::size_t i = 0; i < kThickness_m.size(); ++i) {  // as a star, so that both faces of each plate are seen
    const double degrees = 60.0 * static_cast<double>(i);
    const Vector3d place = Drawing::yaw(degrees) * Vector3d(0.26, 0, 0);
    drawing.stand_box(place.x(), place.y(), kPlinth_m, {0.22, kThickness_m[i], 0.30},
                      paint(static_cast<int>(i), Pattern::kChecks, 0.025), degrees, 0);
  }
  const OrbitPath path{{0, 0, kPlinth_m + 0.12}, 0.85, 0.97, 2.4, 2};
  return std::move(drawing).scene("plates", orbit_path(path), 360);
}

std::unique_ptr<SyntheticScene> room() {
  Drawing drawing;
  drawing.add_room({5.0, 4.0, 2.6}, paint(30, Pattern::kChecks, 0.15));
  drawing.stand_box(0.2, 1.75, 0, {1.8, 0.7, 0.42}, paint(31, Pattern::kStripes, 0.08), 0, 0.04);  // a sofa
  drawing.stand_box(0.2, 1.96, 0.3, {1.8, 0.2, 0.5}, paint(31, Pattern::kChecks, 0.08), 0, 0.04);
  drawing.stand_box(-2.35, 0.3, 0, {0.34, 1.4, 1.9}, paint(32, Pattern::kChecks, 0.1));  // a bookcase
  drawing.stand_box(2.2, -0.4, 0, {0.6, 1.2, 0.74}, paint(33, Pattern::kMarble, 0.06));  // a sideboard
  drawing.add(vase(), {2.2, -0.7, 0.85 - kSunk_m}, paint(34, Pattern::kStripes, 0.02));
  drawing.add(Sphere{0.12}, {2.2, -0.15, 0.86 - kSunk_m}, paint(35, Pattern::kChecks, 0.03));
  drawing.stand_box(-0.8, -1.8, 0, {1.2, 0.5, 0.8}, paint(36, Pattern::kStripes, 0.07));  // a chest
  drawing.add(Torus{0.14, 0.04}, {-0.9, -1.75, 0.84 - kSunk_m}, paint(37, Pattern::kStripes, 0.03));
  drawing.stand_cylinder(1.4, -1.6, 0, 0.22, 0.9, paint(38, Pattern::kChecks, 0.06));
  drawing.stand_box(-2.1, -1.6, 0, {0.5, 0.5, 0.5}, paint(39, Pattern::kMarble, 0.05), 25, 0.02);
  drawing.add(frustum(0.20, 0.12, 0.9), {2.1, 1.5, 0.45 - kSunk_m}, paint(40, Pattern::kStripes, 0.05));
  drawing.add(Sphere{0.26}, {2.1, 1.5, 1.05}, paint(41, Pattern::kMarble, 0.05));
  drawing.add(Box{{0.5, 0.02, 0.35}, 0.004}, {-1.2, 2.0, 1.5}, paint(42, Pattern::kMarble, 0.08));
  drawing.add(Box{{0.02, 0.45, 0.3}, 0.004}, {2.5, 0.7, 1.5}, paint(43, Pattern::kChecks, 0.06));
  drawing.add(Box{{0.6, 0.02, 0.3}, 0.004}, {0.6, -2.0, 1.55}, paint(44, Pattern::kStripes, 0.06));
  return std::move(drawing).scene("room", walk_path({1.3, 0.8, 1.4}), 1000);
}

/// A corridor round a block, with bare walls: the start comes into view again only at the end of 26 m.
std::unique_ptr<SyntheticScene> gallery() {
  constexpr double kHeight_m = 2.6;
  Drawing drawing;
  drawing.add_room({10.0, 8.0, kHeight_m}, bare(50));
  drawing.add(Box{{2.9, 1.9, kHeight_m / 2 + kSunk_m}, 0.02}, {0, 0, kHeight_m / 2}, bare(51));
  drawing.stand_box(1.4, -3.8, 0, {0.9, 0.38, 0.8}, paint(52, Pattern::kStripes, 0.07));  // a chest
  drawing.add(vase(), {1.5, -3.8, 0.91 - kSunk_m}, paint(53, Pattern::kChecks, 0.03));
  drawing.stand_cylinder(4.6, -3.5, 0, 0.25, 1.3, paint(54, Pattern::kChecks, 0.09));
  drawing.stand_box(4.8, -1.0, 0, {0.36, 1.1, 1.8}, paint(55, Pattern::kChecks, 0.10));  // a bookcase
  drawing.add(Box{{0.02, 0.5, 0.4}, 0.004}, {5.0, 1.2, 1.5}, paint(56, Pattern::kMarble, 0.09));
  drawing.stand_box(4.5, 3.5, 0, {0.6, 0.5, 0.5}, paint(57, Pattern::kStripes, 0.06), 25, 0.02);
  drawing.stand_box(1.8, 3.75, 0, {1.4, 0.5, 0.75}, paint(58, Pattern::kMarble, 0.08));  // a bench
  drawing.add(Sphere{0.15}, {1.5, 3.75, 0.9 - kSunk_m}, paint(59, Pattern::kChecks, 0.04));
  drawing.add(Box{{0.7, 0.02, 0.35}, 0.004}, {-1.4, 4.0, 1.5}, paint(60, Pattern::kStripes, 0.07));
  drawing.stand_cylinder(-2.6, 3.6, 0, 0.2, 0.9, paint(61, Pattern::kStripes, 0.05));
  drawing.add(frustum(0.25, 0.12, 1.2), {-4.6, 3.5, 0.6 - kSunk_m}, paint(62, Pattern::kChecks, 0.06));
  drawing.stand_box(-4.75, 1.0, 0, {0.45, 0.9, 1.1}, paint(63, Pattern::kMarble, 0.07));
  drawing.add(Torus{0.16, 0.05}, {-4.7, 1.0, 1.15 - kSunk_m}, paint(64, Pattern::kStripes, 0.03));
  drawing.add(Box{{0.02, 0.45, 0.3}, 0.004}, {-5.0, -1.3, 1.55}, paint(65, Pattern::kChecks, 0.06));
  drawing.stand_box(-4.5, -3.4, 0, {0.5, 0.7, 0.9}, paint(66, Pattern::kChecks, 0.08), -20, 0.02);
  drawing.stand_cylinder(-1.9, -3.65, 0, 0.22, 0.7, paint(67, Pattern::kMarble, 0.05));
  return std::move(drawing).scene("gallery", ring_path({}), 1000);
}

/// Puts a niche with its objects into the corner at (x, y); rotated niches look the same.
void put_niche(Drawing& drawing, double x, double y, double degrees) {
  const Eigen::Matrix3d turn = Drawing::yaw(degrees);
  const auto place = [&](double right, double ahead, double up) {
    const Vector3d at = turn * Vector3d(right, ahead, 0);
    return Vector3d(x + at.x(), y + at.y(), up);
  };
  drawing.add(Box{{1.6, 0.05, 1.25}, 0.004}, place(0, 0, 1.25), paint(71, Pattern::kMarble, 0.11), turn);
  drawing.add(Box{{0.05, 1.3, 1.25}, 0.004}, place(-1.55, -1.25, 1.25), paint(72, Pattern::kChecks, 0.13), turn);
  drawing.add(Box{{1.6, 1.3, 0.02}, 0.004}, place(0, -1.25, 0), paint(73, Pattern::kStripes, 0.12), turn);
  drawing.add(Box{{0.5, 0.25, 0.4}, 0.01}, place(-0.6, -0.35, 0.42 - kSunk_m), paint(74, Pattern::kStripes, 0.06),
              turn);
  drawing.add(Sphere{0.18}, place(-0.7, -0.35, 1.0 - 2 * kSunk_m), paint(75, Pattern::kChecks, 0.05), turn);
  drawing.add(Cylinder{0.2, 0.5, 0.003}, place(0.6, -0.5, 0.5), paint(76, Pattern::kMarble, 0.06), turn);
}

std::unique_ptr<SyntheticScene> twins() {
  Drawing drawing;
  drawing.add_room({9.0, 5.0, 2.6}, paint(70, Pattern::kChecks, 0.16));
  put_niche(drawing, -2.85, 2.4, 0);
  put_niche(drawing, 2.85, -2.4, 180);
  drawing.stand_box(0, 2.2, 0, {0.8, 0.5, 1.1}, paint(77, Pattern::kChecks, 0.09));
  drawing.stand_cylinder(1.6, 2.1, 0, 0.25, 0.8, paint(78, Pattern::kStripes, 0.06));
  drawing.stand_box(3.6, 1.9, 0, {0.9, 0.5, 0.5}, paint(79, Pattern::kMarble, 0.07), 30, 0.02);
  return std::move(drawing).scene("twins", crossing_path({2.0, 1.4, 125 * kDegree}), 300);
}

template <std::unique_ptr<SyntheticScene> (*kDraw)()>
Result<std::unique_ptr<SyntheticScene>> drawn() {
  return kDraw();
}

// In the order of kSceneNames.
constexpr std::array<Result<std::unique_ptr<SyntheticScene>> (*)(), kSceneNames.size()> kScenes = {
    drawn<sphere>,
    drawn<turntable>,
    drawn<tower>,
    drawn<desk>,
    drawn<plates>,
    drawn<room>,
    drawn<gallery>,
    drawn<twins>,
    drawn<clutter_scene>,
    drawn<corridor_scene>,
    drawn<bare_wall_scene>,
    drawn<hall_scene>,
    drawn<cup>,
    board_scene};

}  // namespace

Result<std::unique_ptr<SyntheticScene>> make_scene(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kScenes.size(); ++i) {
    if (name == kSceneNames[i]) return kScenes[i]();
    known += (known.empty() ? "" : ", ") + std::string(kSceneNames[i]);
  }
  return Error{ErrorCode::kUsage, "no such scene; there are: " + known, std::string(name)};
}

}  // namespace scanknit
