#include "synth/scene/real_rooms.h"

#include <utility>
#include <vector>

#include "core/rotation.h"
#include "synth/scene/drawing.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

// Reflectivities in the near infrared, of the order that range finders' data sheets state for such surfaces.
constexpr SurfaceMaterial kScreen{.reflectivity = 0.015f, .gloss = 0.9f};
constexpr SurfaceMaterial kBlackPlastic{.reflectivity = 0.06f, .gloss = 0.3f};
constexpr SurfaceMaterial kRubber{.reflectivity = 0.05f};
constexpr SurfaceMaterial kGlass{.reflectivity = 0.12f, .gloss = 0.9f};
constexpr SurfaceMaterial kGlazed{.reflectivity = 0.6f, .gloss = 0.4f};
constexpr SurfaceMaterial kSteel{.reflectivity = 0.4f, .gloss = 0.6f};
constexpr SurfaceMaterial kPaper{.reflectivity = 0.8f};

constexpr double kTop_m = 0.74;  // of a table

Texture black(double period_m) {
  return {.dark = Vector3d(0.05, 0.05, 0.06), .light = Vector3d(0.16, 0.16, 0.18), .period_m = period_m};
}

void put_table(Drawing& drawing, const Vector3d& size, double leg_radius_m) {
  drawing.add(Box{{size.x() / 2, size.y() / 2, 0.0125}, 0.004}, {0, 0, size.z() - 0.0125},
              paint(107, Pattern::kMarble, 0.06));
  for (const double x : {-0.45, 0.45}) {
    for (const double y : {-0.42, 0.42}) {
      drawing.stand_cylinder(x * size.x(), y * size.y(), 0, leg_radius_m, size.z() - 0.02, black(0.03));
      drawing.made_of(kSteel);
    }
  }
}

/// A screen on its foot, a keyboard with rows of keys, a mouse, and a lamp on a thin arm.
void put_computer(Drawing& drawing) {
  drawing.stand_box(0.05, 0.24, kTop_m, {0.22, 0.16, 0.012}, black(0.02));
  drawing.stand_box(0.05, 0.26, kTop_m, {0.05, 0.03, 0.16}, black(0.02));
  drawing.add(Box{{0.27, 0.014, 0.165}, 0.004}, {0.05, 0.235, kTop_m + 0.29}, black(0.02));
  drawing.made_of(kBlackPlastic);
  drawing.add(Box{{0.258, 0.003, 0.153}, 0}, {0.05, 0.2195, kTop_m + 0.29}, black(0.05));
  drawing.made_of(kScreen);
  drawing.stand_box(0.03, -0.06, kTop_m, {0.42, 0.14, 0.014}, black(0.02), 2);
  drawing.made_of(kBlackPlastic);
  for (int row = 0; row < 4; ++row) {
    drawing.stand_box(0.03 + 0.004 * row, -0.105 + 0.03 * row, kTop_m + 0.014, {0.39, 0.018, 0.006}, black(0.012), 2);
    drawing.made_of(kBlackPlastic);
  }
  drawing.add(Box{{0.032, 0.055, 0.018}, 0.016}, {0.33, -0.07, kTop_m + 0.013}, black(0.02), Drawing::yaw(-12));
  drawing.made_of(kBlackPlastic);
  drawing.stand_cylinder(-0.58, 0.26, kTop_m, 0.08, 0.02, paint(103, Pattern::kStripes, 0.02));
  drawing.add_rod({-0.58, 0.26, kTop_m + 0.02}, {-0.52, 0.24, kTop_m + 0.42}, 0.006, black(0.02));
  drawing.made_of(kSteel);
  drawing.add_rod({-0.52, 0.24, kTop_m + 0.42}, {-0.34, 0.12, kTop_m + 0.46}, 0.006, black(0.02));
  drawing.made_of(kSteel);
  drawing.add(frustum(0.07, 0.03, 0.10), {-0.33, 0.11, kTop_m + 0.43}, paint(104, Pattern::kStripes, 0.03));
}

void put_books_and_paper(Drawing& drawing) {
  struct Flat {
    double x, y, wide, deep, high, turn_deg;
  };
  double top_m = kTop_m;
  const std::vector<Flat> pile = {{-0.42, -0.02, 0.20, 0.27, 0.030, 12},
                                  {-0.43, -0.01, 0.17, 0.24, 0.022, -6},
                                  {-0.41, -0.03, 0.15, 0.21, 0.035, 25},
                                  {-0.42, -0.02, 0.12, 0.18, 0.012, 4}};
  int number = 110;
  for (const Flat& book : pile) {
    drawing.stand_box(book.x, book.y, top_m, {book.wide, book.deep, book.high},
                      paint(number++, Pattern::kStripes, 0.02), book.turn_deg, 0.002);
    drawing.made_of(kPaper);
    top_m += book.high;
  }
  for (const Flat& sheet : {Flat{0.46, 0.05, 0.21, 0.297, 0.002, 17}, Flat{-0.18, -0.24, 0.21, 0.297, 0.003, -31}}) {
    drawing.stand_box(sheet.x, sheet.y, kTop_m, {sheet.wide, sheet.deep, sheet.high},
                      paint(number++, Pattern::kChecks, 0.012), sheet.turn_deg, 0);
    drawing.made_of(kPaper);
  }
  for (int i = 0; i < 4; ++i) {  // books that stand
    drawing.stand_box(0.52 + 0.032 * i, 0.26, kTop_m, {0.024 + 0.004 * (i % 2), 0.16, 0.20 + 0.015 * (i % 3)},
                      paint(number++, Pattern::kStripes, 0.03), 0, 0.002);
    drawing.made_of(kPaper);
  }
}

void put_small_things(Drawing& drawing) {
  drawing.stand_cylinder(-0.16, 0.05, kTop_m, 0.040, 0.095, paint(120, Pattern::kStripes, 0.015));  // a mug
  drawing.made_of(kGlazed);
  drawing.add(Torus{0.028, 0.005}, {-0.205, 0.05, kTop_m + 0.05}, paint(120, Pattern::kChecks, 0.01),
              Drawing::roll(90));
  drawing.made_of(kGlazed);
  drawing.stand_cylinder(0.40, -0.22, kTop_m, 0.033, 0.13, paint(121, Pattern::kMarble, 0.02));  // a glass
  drawing.made_of(kGlass);
  drawing.add(vase(), {0.60, 0.00, kTop_m + 0.11 - kSunk_m}, paint(122, Pattern::kMarble, 0.02));
  drawing.made_of(kGlazed);
  drawing.stand_cylinder(-0.28, 0.26, kTop_m, 0.038, 0.10, black(0.02));  // pens in a cup
  for (int i = 0; i < 4; ++i) {
    const double lean = 0.02 * (i - 1.5);
    drawing.add_rod({-0.28 + lean / 2, 0.26, kTop_m + 0.09}, {-0.28 + 2 * lean, 0.255 + lean, kTop_m + 0.17}, 0.004,
                    paint(123 + i, Pattern::kStripes, 0.01));
  }
  drawing.stand_box(0.27, -0.26, kTop_m, {0.075, 0.15, 0.009}, black(0.03), 40, 0.003);  // a phone
  drawing.made_of(kScreen);
  drawing.add(Sphere{0.035}, {0.20, -0.25, kTop_m + 0.035 - kSunk_m}, paint(127, Pattern::kChecks, 0.02));
  drawing.add(Torus{0.045, 0.010}, {-0.02, -0.24, kTop_m + 0.010 - kSunk_m}, paint(128, Pattern::kStripes, 0.02));
  drawing.stand_box(-0.60, -0.20, kTop_m, {0.12, 0.09, 0.11}, paint(129, Pattern::kChecks, 0.02), 30, 0.006);
  drawing.stand_box(-0.62, -0.05, kTop_m, {0.09, 0.06, 0.05}, paint(130, Pattern::kStripes, 0.02), -15, 0.004);
}

/// Cables of 6 mm: on the desk, and down from its rear edge.
void put_cables(Drawing& drawing) {
  const std::vector<std::vector<Vector3d>> cables = {
      {{0.33, -0.02, kTop_m},
       {0.36, 0.06, kTop_m},
       {0.32, 0.15, kTop_m},
       {0.36, 0.25, kTop_m},
       {0.35, 0.36, kTop_m + 0.01},
       {0.34, 0.38, 0.45},
       {0.28, 0.42, 0.10},
       {0.10, 0.44, 0.01}},
      {{-0.02, 0.02, kTop_m},
       {-0.06, 0.10, kTop_m},
       {-0.07, 0.20, kTop_m},
       {-0.10, 0.36, kTop_m + 0.01},
       {-0.12, 0.38, 0.3}},
      {{-0.58, 0.34, kTop_m}, {-0.57, 0.37, 0.6}, {-0.45, 0.40, 0.15}, {-0.20, 0.44, 0.01}}};
  for (const auto& cable : cables) {
    for (std::size_t i = 0; i + 1 < cable.size(); ++i) {
      drawing.add_rod(cable[i], cable[i + 1], 0.003, black(0.02));
      drawing.made_of(kRubber);
    }
  }
}

/// A chair with legs of 18 mm.
void put_chair(Drawing& drawing, double x, double y) {
  constexpr double kSeat_m = 0.45;
  drawing.add(Box{{0.21, 0.20, 0.015}, 0.01}, {x, y, kSeat_m}, paint(131, Pattern::kMarble, 0.05));
  for (const double side : {-0.18, 0.18}) {
    drawing.add_rod({x + side, y - 0.17, -0.01}, {x + side, y - 0.19, 0.85}, 0.009, black(0.03));
    drawing.made_of(kSteel);
    drawing.add_rod({x + side, y + 0.16, -0.01}, {x + side, y + 0.15, kSeat_m}, 0.009, black(0.03));
    drawing.made_of(kSteel);
  }
  drawing.add(Box{{0.20, 0.012, 0.10}, 0.008}, {x, y - 0.19, 0.76}, paint(131, Pattern::kMarble, 0.05));
}

}  // namespace

std::unique_ptr<SyntheticScene> clutter_scene() {
  Drawing drawing;
  drawing.add_room({3.8, 3.6, 2.5}, bare(100));
  drawing.add(Box{{1.95, 1.85, 0.02}, 0}, {0, 0, -0.01}, paint(101, Pattern::kStripes, 0.09));  // floorboards
  put_table(drawing, {1.5, 0.74, kTop_m}, 0.016);
  put_computer(drawing);
  put_books_and_paper(drawing);
  put_small_things(drawing);
  put_cables(drawing);
  put_chair(drawing, -0.05, -0.55);
  drawing.stand_box(1.7, 0.6, 0, {0.38, 0.9, 1.9}, paint(132, Pattern::kChecks, 0.10));  // a bookcase
  drawing.stand_cylinder(1.0, -0.2, 0, 0.13, 0.32, black(0.04));                         // a bin
  drawing.made_of(kBlackPlastic);
  drawing.add(Box{{0.45, 0.02, 0.32}, 0.004}, {-0.5, 1.8, 1.5}, paint(133, Pattern::kMarble, 0.08));
  drawing.add(Box{{0.02, 0.5, 0.35}, 0.004}, {-1.9, -0.3, 1.4}, paint(134, Pattern::kChecks, 0.07));
  return std::move(drawing).scene("clutter", orbit_path({{0, 0, kTop_m + 0.08}, 1.32, 1.22, 1.22, 1}), 300);
}

std::unique_ptr<SyntheticScene> corridor_scene() {
  Drawing drawing;
  drawing.add_room({1.8, 18, 2.5}, bare(140));
  drawing.add(Box{{0.95, 9.05, 0.02}, 0}, {0, 0, -0.01}, paint(141, Pattern::kChecks, 0.30));
  for (int i = 0; i < 5; ++i) {
    const double y = -7 + 3.4 * i;
    const double side = i % 2 == 0 ? -0.9 : 0.9;
    drawing.add(Box{{0.03, 0.45, 1.02}, 0.003}, {side, y, 1.01}, paint(142 + i, Pattern::kMarble, 0.15));
    drawing.add_rod({0.95 * side, y + 0.36, 1.0}, {0.95 * side, y + 0.26, 1.0}, 0.01, black(0.02));
    drawing.made_of(kSteel);
    drawing.add(Box{{0.012, 0.12, 0.16}, 0.002}, {-side, y + 0.5, 1.5}, paint(150 + i, Pattern::kChecks, 0.04));
  }
  drawing.stand_cylinder(0.8, 1.6, 0.5, 0.07, 0.5, paint(156, Pattern::kStripes, 0.05));  // an extinguisher
  drawing.made_of(kGlazed);
  drawing.stand_box(-0.72, 5.0, 0, {0.32, 1.2, 0.44}, paint(157, Pattern::kStripes, 0.06));  // a bench
  drawing.add(Box{{0.6, 0.03, 1.0}, 0.003}, {0, 9, 1.0}, black(0.2));                        // a glazed door at the end
  drawing.made_of(kGlass);
  const StraightPath path{{0.05, -8.2, 1.45}, {-0.05, 4.0, 1.45}, 90 * kDegree, 14 * kDegree, -0.12};
  return std::move(drawing).scene("corridor", straight_path(path), 600);
}

std::unique_ptr<SyntheticScene> bare_wall_scene() {
  Drawing drawing;
  drawing.add_room({5.0, 4.0, 2.6}, bare(160));
  for (const double x : {-1.65, 1.65}) {
    drawing.add(Box{{0.35, 0.012, 0.45}, 0.003}, {x, 2.0, 1.4}, paint(161, Pattern::kChecks, 0.07));
    drawing.made_of(kPaper);
  }
  drawing.stand_box(0, -1.7, 0, {1.6, 0.5, 0.8}, paint(162, Pattern::kStripes, 0.07));
  const StraightPath path{{-1.5, 0.8, 1.4}, {1.5, 0.8, 1.4}, 90 * kDegree, 0, -0.05};
  return std::move(drawing).scene("bare_wall", straight_path(path), 240);
}

std::unique_ptr<SyntheticScene> hall_scene() {
  Drawing drawing;
  drawing.add_room({16, 59, 7}, bare(170));
  drawing.add(Box{{8.1, 29.6, 0.02}, 0}, {0, 0, -0.01}, paint(171, Pattern::kChecks, 0.6));
  for (int i = 0; i < 8; ++i) {
    const double y = -24.5 + 7 * i;
    for (const double x : {-5.0, 5.0}) {
      drawing.stand_box(x, y, 0, {0.4, 0.4, 6.98}, paint(172 + i, Pattern::kMarble, 0.4));
      drawing.stand_box(1.35 * x, y + 3, 0, {1.4, 1.0 + 0.2 * (i % 3), 0.9 + 0.4 * (i % 4)},
                        paint(180 + i, Pattern::kStripes, 0.2), 12.0 * i);
    }
  }
  put_table(drawing, {0.8, 0.6, kTop_m}, 0.02);
  drawing.stand_box(-0.20, 0.10, kTop_m, {0.12, 0.09, 0.14}, paint(190, Pattern::kChecks, 0.02), 20);
  drawing.stand_box(0.10, 0.16, kTop_m, {0.20, 0.14, 0.07}, paint(191, Pattern::kStripes, 0.02), -10);
  drawing.stand_cylinder(0.24, -0.05, kTop_m, 0.035, 0.12, paint(192, Pattern::kMarble, 0.02));
  drawing.made_of(kGlazed);
  drawing.add(vase(), {-0.05, 0.00, kTop_m + 0.11 - kSunk_m}, paint(193, Pattern::kMarble, 0.02));
  drawing.add(Sphere{0.04}, {-0.25, -0.12, kTop_m + 0.04 - kSunk_m}, paint(194, Pattern::kChecks, 0.02));
  drawing.add(Torus{0.05, 0.015}, {0.08, -0.16, kTop_m + 0.015 - kSunk_m}, paint(195, Pattern::kStripes, 0.02));
  drawing.stand_box(0.28, 0.20, kTop_m, {0.06, 0.06, 0.20}, black(0.03), 5);
  drawing.made_of(kBlackPlastic);
  return std::move(drawing).scene("hall", orbit_path({{0, 0, kTop_m + 0.06}, kTop_m + 0.30, 0.78, 0.78, 1}), 240);
}

}  // namespace scanknit
