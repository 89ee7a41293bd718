#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "export/picture/preview.h"
#include "export/picture/rasteriser.h"
#include "export/picture/view_choice.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

constexpr int kSize = 200;

bool is_drawn(Rgb8 pixel) {
  return !(pixel == kBackground);
}

std::size_t drawn_pixels(const ColourImage& picture) {
  return static_cast<std::size_t>(std::count_if(picture.pixels().begin(), picture.pixels().end(), is_drawn));
}

/// A camera on -y that looks along +y, z up: +x is right in the picture.
const View kFromMinusY{{0, 1, 0}, {0, 0, 1}, true};

ColourImage render(const Mesh& mesh, const View& view = kFromMinusY) {
  return render_view(mesh, framing(mesh), view, kSize, kSize);
}

bool is_reddish(Rgb8 c) {
  return c.r > c.g + 40 && c.r > c.b + 40;
}

TEST(RenderView, SphereHasTheAreaOfItsSilhouette) {
  const ColourImage picture = render(test::sphere());
  // The point of the unit sphere that needs most distance maximises 1.04 s / tan(17.5 deg) + z over s^2 + z^2 = 1.
  const double distance = std::hypot(1.04 / std::tan(17.5 * std::numbers::pi / 180), 1);
  const double focal_px = kSize / (2 * std::tan(17.5 * std::numbers::pi / 180));
  const double radius_px = focal_px / std::sqrt(distance * distance - 1);  // the cone that touches the unit sphere
  const double expected = std::numbers::pi * radius_px * radius_px;
  const double rim = 2 * std::numbers::pi * radius_px;  // half-covered pixels count as drawn: half a pixel all round
  EXPECT_NEAR(static_cast<double>(drawn_pixels(picture)), expected + rim / 2, rim / 2);
}

TEST(RenderView, RedMarkerOfPlusXIsOnTheRight) {
  const ColourImage picture = render(test::marked_sphere());
  int left = 0, right = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) (x < kSize / 2 ? left : right) += is_reddish(picture.at(x, y)) ? 1 : 0;
  }
  EXPECT_EQ(left, 0);
  EXPECT_GT(right, 100);
}

TEST(RenderView, UpIsUp) {
  const ColourImage picture = render(test::marked_sphere());
  const auto is_bluish = [](Rgb8 c) { return c.b > c.r + 40; };
  const auto rows = [&](int from, int to) {
    int count = 0;
    for (int y = from; y < to; ++y) count += static_cast<int>(std::ranges::count_if(picture.row(y), is_bluish));
    return count;
  };
  EXPECT_GT(rows(0, kSize / 2), 100);
  EXPECT_EQ(rows(kSize / 2, kSize), 0);
}

TEST(RenderView, NearSurfaceHidesTheFarOne) {
  Mesh mesh = test::cube();
  for (const Eigen::Vector3f& p : mesh.positions_m)
    mesh.colours.push_back(p.y() < 0 ? Rgb8{255, 0, 0} : Rgb8{0, 0, 255});
  EXPECT_TRUE(is_reddish(render(mesh).at(kSize / 2, kSize / 2)));
}

TEST(RenderView, LooksIntoARoomThroughItsNearWall) {
  Mesh room = test::cube();
  for (const Eigen::Vector3f& p : room.positions_m)
    room.colours.push_back(p.y() < 0 ? Rgb8{255, 0, 0} : Rgb8{0, 0, 255});
  for (Triangle& t : room.triangles) std::swap(t[0], t[1]);  // walls that face inwards
  const Rgb8 centre = render(room).at(kSize / 2, kSize / 2);
  EXPECT_GT(centre.b, centre.r + 40);
}

TEST(RenderView, ClayShowsNoColour) {
  View clay = kFromMinusY;
  clay.in_colour = false;
  const ColourImage picture = render(test::marked_sphere(), clay);
  EXPECT_TRUE(std::ranges::all_of(picture.pixels(), [](Rgb8 c) { return c.r == c.g && c.g == c.b; }));
  EXPECT_GT(drawn_pixels(picture), 0u);
}

TEST(RenderView, ClosedSurfaceHasNoHoles) {
  // Between the first and last drawn pixel of a row everything is drawn: neighbours leave no cracks.
  const ColourImage picture = render(test::sphere());
  for (int y = 0; y < kSize; ++y) {
    const auto row = picture.row(y);
    const auto first = std::find_if(row.begin(), row.end(), is_drawn);
    const auto last = std::find_if(row.rbegin(), row.rend(), is_drawn).base();
    if (first < last) {
      EXPECT_TRUE(std::all_of(first, last, is_drawn)) << y;
    }
  }
}

TEST(RenderView, EmptyMeshIsAnEmptyBackground) {
  EXPECT_EQ(drawn_pixels(render(Mesh{})), 0u);
  EXPECT_EQ(drawn_pixels(render_preview(Mesh{}, UpAxis::kZ, std::nullopt, 64, 48)), 0u);
}

TEST(RenderView, OnePointAndAStrayVertexFarAwayAreAnswered) {
  Mesh point;
  point.positions_m.assign(3, Eigen::Vector3f(1, 2, 3));
  point.triangles = {{0, 1, 2}};
  EXPECT_EQ(drawn_pixels(render(point)), 0u);
  Mesh stray = test::sphere();
  stray.positions_m.emplace_back(1e30f, 0, 0);
  stray.normals.emplace_back(1, 0, 0);
  stray.triangles.push_back({0, 1, static_cast<std::uint32_t>(stray.positions_m.size() - 1)});
  EXPECT_GT(drawn_pixels(render(stray)), kSize * kSize / 4u);
}

TEST(Framing, IgnoresAFewStrayVertices) {
  Mesh mesh = test::sphere();
  mesh.positions_m.emplace_back(100, 0, 0);
  EXPECT_LE(framing(mesh).max_m.x(), 1.0);
}

TEST(Framing, KeepsAThinPartOfTheObject) {
  Mesh mesh = test::sphere();
  mesh.positions_m.emplace_back(1.4f, 0, 0);
  EXPECT_GT(framing(mesh).max_m.x(), 1.3);
}

TEST(ChooseViews, AScanFromOneSideIsNotShownFromBehind) {
  Mesh wall;  // faces -x
  wall.positions_m = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
  wall.triangles = {{0, 2, 1}, {0, 3, 2}};
  for (const View& view : choose_views(wall, UpAxis::kZ)) EXPECT_GT(view.forward.x(), 0);
}

TEST(ChooseViews, EveryViewIsUprightAndUnit) {
  constexpr double kRounding = 1e-12;
  for (const View& view : choose_views(test::marked_sphere(), UpAxis::kMinusY)) {
    EXPECT_EQ(view.up, Eigen::Vector3d(0, -1, 0));
    EXPECT_NEAR(view.forward.norm(), 1, kRounding);
    EXPECT_LT(view.forward.dot(view.up), 0);  // looks down a little
  }
}

TEST(RenderPreview, IsTheSamePictureEveryTime) {
  const Mesh mesh = test::marked_sphere();
  EXPECT_EQ(render_preview(mesh, UpAxis::kZ, std::nullopt, 320, 240),
            render_preview(mesh, UpAxis::kZ, std::nullopt, 320, 240));
}

TEST(RenderPreview, FillsAllFourQuarters) {
  const ColourImage picture = render_preview(test::marked_sphere(), UpAxis::kZ, std::nullopt, 320, 240);
  for (const auto& [x, y] : {std::pair{80, 60}, {240, 60}, {80, 180}, {240, 180}})
    EXPECT_TRUE(is_drawn(picture.at(x, y)));
}

TEST(RenderPreview, ShowsFirstWhatTheScannerSaw) {
  // Red is on +x, blue on +z: a scanner on the +z axis looks at the blue side.
  Pose T_world_scanner = Pose::Identity();
  T_world_scanner.linear() = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T_world_scanner.translation() = Eigen::Vector3d(0, 0, 5);
  const ColourImage picture = render_preview(test::marked_sphere(), UpAxis::kY, T_world_scanner, 320, 240);
  const Rgb8 middle = picture.at(80, 60);
  EXPECT_GT(middle.b, 2 * middle.r);
  EXPECT_GT(middle.b, 2 * middle.g);
}

TEST(WritePng, WritesASignedPng) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(write_png(render(test::marked_sphere()), folder / "p.png"));
  EXPECT_TRUE(test::read_text(folder / "p.png").starts_with("\x89PNG\r\n\x1a\n"));
}

}  // namespace
}  // namespace scanknit
