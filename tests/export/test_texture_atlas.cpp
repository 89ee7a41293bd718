// A mesh unfolded into a texture.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <set>
#include <tuple>

#include "export/texture/atlas_charts.h"
#include "export/texture/atlas_packing.h"
#include "tests/core/welded_mesh.h"
#include "tests/export/texture_samples.h"

namespace scanknit {
namespace {

int most(const Image<int>& counts) {
  return *std::max_element(counts.pixels().begin(), counts.pixels().end());
}

TEST(TexelRaster, TrianglesOfASquareHaveEachTexelOnce) {
  constexpr std::int32_t kSide = 20 * kTexelSteps;
  Image<int> count(21, 21, 0);
  const std::array<std::array<TexelPoint, 3>, 2> halves = {
      {{{{0, 0}, {kSide, 0}, {kSide, kSide}}}, {{{0, 0}, {kSide, kSide}, {0, kSide}}}}};
  for (const auto& half : halves) {
    for_each_texel(half, [&](int x, int y, const auto&) { return ++count.at(x, y), true; });
  }
  EXPECT_EQ(most(count), 1);
  EXPECT_EQ(std::count(count.pixels().begin(), count.pixels().end(), 1), 20 * 20);
}

TEST(TexelRaster, WeightsGiveTheTexelBackWhateverTheWinding) {
  std::array<TexelPoint, 3> p = {{{100, 300}, {9000, 1200}, {2500, 8000}}};
  for (int turned = 0; turned < 2; ++turned, std::swap(p[0], p[2])) {
    int texels = 0;
    for_each_texel(p, [&](int x, int y, const std::array<float, 3>& w) {
      const auto mixed = [&](auto coordinate) {
        return w[0] * static_cast<float>(coordinate(p[0])) + w[1] * static_cast<float>(coordinate(p[1])) +
               w[2] * static_cast<float>(coordinate(p[2]));
      };
      EXPECT_NEAR(mixed([](auto& q) { return q.x; }), x * 256, 0.01);
      EXPECT_NEAR(mixed([](auto& q) { return q.y; }), y * 256, 0.01);
      return ++texels, true;
    });
    EXPECT_GT(texels, 300);
  }
}

TEST(AtlasCharts, ASpiralThatLooksUpEverywhereIsCutWhereItLiesOverItself) {
  const Mesh ramp = test::spiral_ramp();
  const Charts charts = grow_charts(ramp, 0.02, 1024);
  EXPECT_GE(charts.planes.size(), 2u);
  EXPECT_EQ(most(test::coverage(test::atlas_of(ramp, 0.02))), 1);
}

TEST(AtlasCharts, AFlatWallIsOneChart) {
  EXPECT_EQ(grow_charts(test::wall(), 0.002, 1024).planes.size(), 1u);
}

TEST(AtlasCharts, NoTriangleLeansMoreThan78DegreesFromItsChart) {
  const Mesh mesh = test::torus(64, 32);
  const Charts charts = grow_charts(mesh, 0.01, 1024);
  EXPECT_LT(charts.planes.size(), 40u);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3f& p = mesh.positions_m[a];
    const Eigen::Vector3d n = (mesh.positions_m[b] - p).cross(mesh.positions_m[c] - p).cast<double>();
    const ChartPlane& plane = charts.planes[charts.chart_of[t]];
    EXPECT_GE(n.normalized().dot(plane.u.cross(plane.v)), 0.2 - 1e-6);
  }
}

TEST(AtlasCharts, AreNoLargerThanAsked) {
  const Mesh wall = test::wall(64);
  const Charts charts = grow_charts(wall, 0.001, 100);  // the wall is 400 texels wide
  EXPECT_GE(charts.planes.size(), 16u);
  std::map<std::uint32_t, std::array<std::int32_t, 4>> extents;
  for (std::size_t t = 0; t < wall.triangles.size(); ++t) {
    const std::uint32_t chart = charts.chart_of[t];
    for (const TexelPoint& p : charts.planes[chart].project(wall, wall.triangles[t])) {
      auto& [x0, x1, y0, y1] = extents.try_emplace(chart, std::array{p.x, p.x, p.y, p.y}).first->second;
      std::tie(x0, x1, y0, y1) = std::tuple(std::min(x0, p.x), std::max(x1, p.x), std::min(y0, p.y), std::max(y1, p.y));
    }
  }
  for (const auto& [chart, e] : extents) {
    EXPECT_LE(e[1] - e[0], 100 * kTexelSteps);
    EXPECT_LE(e[3] - e[2], 100 * kTexelSteps);
  }
}

TEST(AtlasPacking, BoxesLieInsideAndApart) {
  std::vector<AtlasBox> boxes;
  for (int i = 0; i < 200; ++i) boxes.push_back({7 + i * 37 % 90, 5 + i * 53 % 70});
  const auto packing = pack_boxes(boxes, 4096);
  ASSERT_TRUE(packing);
  Image<int> count(packing->width, packing->height, 0);
  long long area = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    area += boxes[i].width * boxes[i].height;
    for (int y = 0; y < boxes[i].height; ++y) {
      for (int x = 0; x < boxes[i].width; ++x) {
        ASSERT_TRUE(count.contains(packing->places[i].x + x, packing->places[i].y + y));
        ++count.at(packing->places[i].x + x, packing->places[i].y + y);
      }
    }
  }
  EXPECT_EQ(most(count), 1);
  EXPECT_GT(static_cast<double>(area), 0.8 * packing->width * packing->height);
}

TEST(AtlasPacking, WhatIsTooMuchIsRefused) {
  EXPECT_FALSE(pack_boxes(std::vector<AtlasBox>(5, {60, 60}), 120));
  EXPECT_FALSE(pack_boxes(std::vector<AtlasBox>{{200, 1}}, 120));
  EXPECT_FALSE(pack_boxes(std::vector<AtlasBox>{{1, 200}}, 120));
  EXPECT_TRUE(pack_boxes(std::vector<AtlasBox>(4, {60, 60}), 120));
}

TEST(TextureAtlas, WeldedByPositionItIsTheSameMesh) {
  for (const Mesh& mesh : {test::sphere(), test::torus(), test::cube(), test::tetrahedron()}) {
    const TextureAtlas atlas = test::atlas_of(mesh, 0.01);
    const Mesh unfolded = atlas.unfolded(mesh);
    ASSERT_EQ(unfolded.triangles.size(), mesh.triangles.size());
    for (std::size_t v = 0; v < mesh.positions_m.size(); ++v) {
      EXPECT_EQ(unfolded.positions_m[v], mesh.positions_m[v]);  // copies come behind
    }
    EXPECT_GT(unfolded.positions_m.size(), mesh.positions_m.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(atlas.source[atlas.triangles[t][k]], mesh.triangles[t][k]);
    }
    const MeshCheck before = check_mesh(mesh), after = check_mesh(test::welded(unfolded));
    EXPECT_EQ(after.vertices, before.vertices);
    EXPECT_EQ(after.euler, before.euler);
    EXPECT_EQ(after.is_closed(), before.is_closed());
    EXPECT_EQ(after.is_manifold(), before.is_manifold());
  }
}

TEST(TextureAtlas, NoTexelBelongsToTwoTriangles) {
  for (const Mesh& mesh : {test::sphere(), test::torus(), test::cube(), test::spiral_ramp(4)}) {
    EXPECT_EQ(most(test::coverage(test::atlas_of(mesh, 0.013))), 1);
  }
}

TEST(TextureAtlas, ChartsKeepTwoGuttersApart) {
  const TextureAtlas atlas = test::atlas_of(test::sphere(), 0.02);
  ASSERT_GE(atlas.charts, 4u);
  Image<std::uint32_t> chart(atlas.width, atlas.height, 0);
  for (std::size_t t = 0; t < atlas.triangles.size(); ++t) {
    for_each_texel(atlas.corners(t),
                   [&](int x, int y, const auto&) { return chart.at(x, y) = atlas.chart_of[t] + 1, true; });
  }
  for (int y = 0; y < atlas.height; ++y) {
    for (int x = 0; x < atlas.width; ++x) {
      if (chart.at(x, y) == 0) continue;
      for (int dy = -2 * kAtlasGutter; dy <= 2 * kAtlasGutter; ++dy) {
        for (int dx = -2 * kAtlasGutter; dx <= 2 * kAtlasGutter; ++dx) {
          if (!chart.contains(x + dx, y + dy) || chart.at(x + dx, y + dy) == 0) continue;
          EXPECT_EQ(chart.at(x + dx, y + dy), chart.at(x, y));
        }
      }
    }
  }
}

TEST(TextureAtlas, TexelsStandForTheirAreaOfTheSurface) {
  const TextureAtlas atlas = test::atlas_of(test::wall(), 0.001);
  const Image<int> count = test::coverage(atlas);
  EXPECT_NEAR(static_cast<double>(std::count(count.pixels().begin(), count.pixels().end(), 1)), 400.0 * 400, 2 * 400);
}

TEST(TextureAtlas, CoordinatesPointIntoTheTexture) {
  const TextureAtlas atlas = test::atlas_of(test::torus(), 0.02);
  for (std::size_t v = 0; v < atlas.source.size(); ++v) {
    const Eigen::Vector2f uv = atlas.coordinate(v);
    EXPECT_TRUE((uv.array() > 0).all() && (uv.array() < 1).all());
  }
}

TEST(TextureAtlas, IsTheSameForAnyNumberOfThreads) {
  const Mesh mesh = test::torus(200, 100);
  const TextureAtlas many = test::atlas_of(mesh, 0.01);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const TextureAtlas alone = test::atlas_of(mesh, 0.01);
  EXPECT_TRUE(many.places == alone.places && many.source == alone.source && many.chart_of == alone.chart_of);
}

TEST(TextureAtlas, TexelsBecomeCoarserWhereTheTextureWouldBeTooLarge) {
  AtlasRequest request;
  request.texel = 0.001;
  request.max_side = 256;
  const auto atlas = build_atlas(test::sphere(), request);
  ASSERT_TRUE(atlas) << atlas.error().text();
  EXPECT_LE(std::max(atlas->width, atlas->height), 256);
  EXPECT_GT(atlas->texel, 0.005);
  request.may_be_coarser = false;
  const auto refused = build_atlas(test::sphere(), request);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBudget);
  EXPECT_NE(refused.error().message.find("export.texel_size"), std::string::npos) << refused.error().message;
}

TEST(TextureAtlas, TheLargestTextureIsNoLarger) {
  AtlasRequest request;
  request.texel = 0.00004;  // the wall alone would be 10,000 texels wide
  request.max_side = 16384;
  const auto atlas = build_atlas(test::wall(64), request);
  ASSERT_TRUE(atlas) << atlas.error().text();
  EXPECT_LE(std::max(atlas->width, atlas->height), 16384);
}

TEST(TextureAtlas, MoreLooseTrianglesThanFitAreRefusedWithTheAlternative) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const float x = 2 * static_cast<float>(i);
    mesh.positions_m.insert(mesh.positions_m.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  AtlasRequest request;
  request.max_side = 64;  // room for some 64 charts with their gutters
  const auto refused = build_atlas(mesh, request);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBudget);
  EXPECT_NE(refused.error().message.find("finish.triangles"), std::string::npos) << refused.error().message;
}

TEST(TextureAtlas, OneTriangleSliversAndLooseVerticesCome) {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {0.5f, 0, 0}, {7, 7, 7}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(test::atlas_of(mesh, 0.01).charts, 1u);
  mesh.triangles.push_back({0, 3, 1});  // three in a line
  mesh.triangles.push_back({4, 4, 4});
  const TextureAtlas atlas = test::atlas_of(mesh, 0.01);
  EXPECT_EQ(atlas.triangles.size(), 3u);
  EXPECT_EQ(most(test::coverage(atlas)), 1);
  mesh.triangles = {{4, 4, 4}};
  EXPECT_EQ(test::atlas_of(mesh, 0.01).charts, 1u);
}

TEST(TextureAtlas, ATriangleOfKilometresBesideOneOfMillimetresIsNoTrouble) {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1e-3f, 0, 0}, {0, 1e-3f, 0}, {1e6f, 0, 1}, {0, 1e6f, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const TextureAtlas atlas = test::atlas_of(mesh, 0.001);
  EXPECT_LE(std::max(atlas.width, atlas.height), 4096);
}

TEST(TextureAtlas, AMeshWithoutTrianglesIsRefused) {
  const auto refused = build_atlas({}, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kMesh);
}

}  // namespace
}  // namespace scanknit
