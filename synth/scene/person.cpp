#include "synth/scene/person.h"

#include <cmath>
#include <utility>
#include <vector>

#include "core/rotation.h"
#include "synth/scene/drawing.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr SurfaceMaterial kCloth{.reflectivity = 0.45f};
constexpr SurfaceMaterial kDarkCloth{.reflectivity = 0.12f};
constexpr int kTrousers = 93;  // number of their paint

/// On the plan: where the person sits or turns round, and how far and in which direction they walk.
struct Place {
  std::string_view scene;
  Vector3d at_m;
  double heading_deg;  ///< of the walk; who sits looks along -y
  double half_way_m;
};

Place place_in(std::string_view scene) {
  static const Place kPlaces[] = {
      {"corridor", {0.35, 4.5, 0}, 90, 1.5}, {"hall", {0.4, 3.5, 0}, 10, 2.5}, {"bare_wall", {0, 1.2, 0}, 0, 1.2},
      {"clutter", {0.2, 1.55, 0}, 0, 0.9},   {"room", {0.2, 1.0, 0}, 0, 1.4},
  };
  for (const Place& place : kPlaces) {
    if (place.scene == scene) return place;
  }
  return {scene, {0, 1.3, 0}, 0, 1.1};
}

void add_limb(Drawing& drawing, const Vector3d& from, const Vector3d& to, double radius_m, int paint_number) {
  drawing.add_rod(from, to, radius_m, paint(paint_number, Pattern::kMarble, 0.08));
  drawing.made_of(paint_number == kTrousers ? kDarkCloth : kCloth);
}

/// Right, ahead, up, seen from the person.
class Body {
 public:
  Body(const Vector3d& at_m, double heading_deg) : at_m_(at_m), turn_(Drawing::yaw(heading_deg - 90)) {}
  [[nodiscard]] Vector3d operator()(double right, double ahead, double up) const {
    return at_m_ + turn_ * Vector3d(right, ahead, up);
  }
  [[nodiscard]] const Eigen::Matrix3d& turn() const { return turn_; }

 private:
  Vector3d at_m_;
  Eigen::Matrix3d turn_;
};

/// From the hips to the head, with hips at `hips_m` above the floor.
void add_trunk(Drawing& drawing, const Body& body, double hips_m, double lean_m) {
  drawing.add(Box{{0.2, 0.12, 0.3}, 0.1}, body(lean_m / 2, 0, hips_m + 0.28), paint(91, Pattern::kStripes, 0.06),
              body.turn(), kCloth);
  drawing.add(Sphere{0.11}, body(lean_m, 0.02, hips_m + 0.74), paint(92, Pattern::kMarble, 0.05), body.turn(), kCloth);
}

void add_walker(Drawing& drawing, const Place& place, double time_s) {
  constexpr double kPace_m_s = 1.1;
  constexpr double kStep_hz = 0.9;
  // To and fro at a steady pace, as a triangle wave.
  const double period_s = 4 * place.half_way_m / kPace_m_s;
  const double phase = time_s / period_s - std::floor(time_s / period_s);
  const bool is_outward = phase < 0.5;
  const double along = place.half_way_m * (is_outward ? 4 * phase - 1 : 3 - 4 * phase);
  const Vector3d way = Drawing::yaw(place.heading_deg) * Vector3d::UnitX();
  const Body body(place.at_m + along * way, place.heading_deg + (is_outward ? 0 : 180));
  const double swing = 0.28 * std::sin(kFullTurn * kStep_hz * time_s);
  add_trunk(drawing, body, 0.9, 0);
  for (const double side : {-1.0, 1.0}) {
    add_limb(drawing, body(0.1 * side, 0, 0.9), body(0.1 * side, side * swing, 0.08), 0.075, kTrousers);
    add_limb(drawing, body(0.26 * side, 0, 1.42), body(0.28 * side, -side * swing, 0.88), 0.05, 91);
  }
}

void add_sitter(Drawing& drawing, const Place& place, double time_s) {
  const Body body(place.at_m, -90);
  const double sway_m = 0.03 * std::sin(kFullTurn * 0.23 * time_s) + 0.01 * std::sin(kFullTurn * 0.71 * time_s);
  const double reach = 0.5 + 0.5 * std::sin(kFullTurn * 0.31 * time_s);
  drawing.add(Box{{0.22, 0.21, 0.03}, 0.01}, body(0, 0, 0.45), paint(94, Pattern::kChecks, 0.05), body.turn());
  add_trunk(drawing, body, 0.5, sway_m);
  for (const double side : {-1.0, 1.0}) {
    add_limb(drawing, body(0.18 * side, -0.16, 0), body(0.18 * side, -0.16, 0.44), 0.02, 94);  // a chair's legs
    add_limb(drawing, body(0.11 * side, 0, 0.54), body(0.12 * side, 0.42, 0.54), 0.08, kTrousers);
    add_limb(drawing, body(0.12 * side, 0.42, 0.5), body(0.12 * side, 0.44, 0.08), 0.06, kTrousers);
  }
  add_limb(drawing, body(0.26 + sway_m, 0, 1.02), body(0.24, 0.15 + 0.3 * reach, 0.72 + 0.3 * reach), 0.05, 91);
  add_limb(drawing, body(-0.26 + sway_m, 0, 1.02), body(-0.22, 0.25, 0.68), 0.05, 91);
}

}  // namespace

std::unique_ptr<SyntheticScene> person_at(PersonKind kind, std::string_view scene, double time_s) {
  if (kind == PersonKind::kNobody) return nullptr;
  Drawing drawing;
  const Place place = place_in(scene);
  kind == PersonKind::kSitting ? add_sitter(drawing, place, time_s) : add_walker(drawing, place, time_s);
  return std::move(drawing).scene(
      "person", [](double) { return Pose::Identity(); }, 1);
}

}  // namespace scanknit
