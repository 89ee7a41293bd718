// GLB files of several primitives: a large mesh, cut up and read back whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

#include "export/glb/glb_writer.h"
#include "export/mesh/mesh_readers.h"
#include "export/mesh/write_mesh.h"
#include "export/texture/mesh_texture.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/every_packing.h"
#include "tests/export/texture_samples.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

constexpr std::size_t kMostVertices = 500;

std::string glb_of(const Mesh& mesh, ExportConfig config, std::size_t most_vertices,
                   const MeshTexture* texture = nullptr) {
  const TemporaryFolder folder;
  config.max_vertices_of_a_primitive = most_vertices;
  const auto written = write_mesh(mesh, folder / "m.glb", config, UpAxis::kY, std::nullopt, texture);
  EXPECT_TRUE(written) << written.error().text();
  return test::read_text(folder / "m.glb");
}

nlohmann::json json_of(const std::string& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof(length));
  return nlohmann::json::parse(glb.substr(20, length));
}

Mesh read_back(const std::string& glb) {
  const auto mesh = parse_mesh(glb, MeshFormat::kGlb, {});
  EXPECT_TRUE(mesh) << mesh.error().text();
  return mesh ? *mesh : Mesh{};
}

using Corner = std::array<float, 9>;

/// The triangles by what their corners have, in an order of their own.
std::vector<std::array<Corner, 3>> facets(const Mesh& mesh) {
  std::vector<std::array<Corner, 3>> all;
  for (const Triangle& t : mesh.triangles) {
    std::array<Corner, 3>& facet = all.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3f &p = mesh.positions_m[t[i]], &n = mesh.normals[t[i]];
      const Rgb8 c = mesh.colours.empty() ? Rgb8{} : mesh.colours[t[i]];
      const auto channel = [](std::uint8_t byte) { return static_cast<float>(byte); };
      facet[i] = {p.x(), p.y(), p.z(), n.x(), n.y(), n.z(), channel(c.r), channel(c.g), channel(c.b)};
    }
    std::rotate(facet.begin(), std::min_element(facet.begin(), facet.end()), facet.end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

void expect_same_surface(const Mesh& mesh, const Mesh& expected) {
  const MeshCheck is = check_mesh(mesh), should_be = check_mesh(expected);
  EXPECT_EQ(is.vertices, should_be.vertices);
  EXPECT_EQ(is.boundary_edges, should_be.boundary_edges);
  EXPECT_EQ(is.components, should_be.components);
  EXPECT_EQ(is.euler, should_be.euler);
  EXPECT_EQ(is.is_manifold(), should_be.is_manifold());
  EXPECT_TRUE(facets(mesh) == facets(expected));
}

class GlbParts : public test::EveryPacking {};

TEST_P(GlbParts, NoneHasMoreVerticesThanItMay) {
  const auto json = json_of(glb_of(test::marked_sphere(), config(), kMostVertices));
  EXPECT_EQ(json["meshes"].size(), 1u);
  const auto& primitives = json["meshes"][0]["primitives"];
  EXPECT_GT(primitives.size(), test::sphere().positions_m.size() / kMostVertices);
  std::size_t corners = 0;
  for (const auto& primitive : primitives) {
    EXPECT_EQ(primitive["material"], 0);
    EXPECT_EQ(primitive["attributes"].size(), 3u);
    for (const auto& attribute : primitive["attributes"]) {
      EXPECT_LE(json["accessors"][attribute.get<std::size_t>()]["count"], kMostVertices);
    }
    corners += json["accessors"][primitive["indices"].get<std::size_t>()]["count"].get<std::size_t>();
  }
  EXPECT_EQ(corners, 3 * test::sphere().triangles.size());
  EXPECT_EQ(json["materials"].size(), 1u);
}

TEST_P(GlbParts, AreReadAsTheOneSurfaceTheyWere) {
  const Mesh mesh = test::marked_sphere();
  const Mesh again = read_back(glb_of(mesh, config(), kMostVertices));
  expect_same_surface(again, read_back(glb_of(mesh, config(), mesh.positions_m.size())));
  EXPECT_TRUE(check_mesh(again).is_closed());
}

TEST_P(GlbParts, ShareOnePictureAndKeepItsSeams) {
  const test::Textured made = test::textured(test::sphere());
  const std::string glb = glb_of(made.mesh, config(), kMostVertices, &made.texture);
  EXPECT_EQ(json_of(glb)["images"].size(), 1u);
  EXPECT_GT(json_of(glb)["meshes"][0]["primitives"].size(), 1u);
  const Mesh whole = read_back(glb_of(made.mesh, config(), made.mesh.positions_m.size(), &made.texture));
  ASSERT_FALSE(check_mesh(whole).is_closed());
  expect_same_surface(read_back(glb), whole);
}

TEST_P(GlbParts, AHoleStaysAsItIs) {
  Mesh mesh = test::marked_sphere();
  mesh.triangles.resize(mesh.triangles.size() - 100);
  const Mesh whole = read_back(glb_of(mesh, config(), mesh.positions_m.size()));
  ASSERT_FALSE(check_mesh(whole).is_closed());
  Mesh again = read_back(glb_of(mesh, config(), kMostVertices));
  EXPECT_EQ(check_mesh(again).boundary_edges, check_mesh(whole).boundary_edges);
}

/// Two cubes with a corner at one place, or with an edge: two surfaces, whose vertices are equal there in all they
/// have.
Mesh touching_cubes(const Eigen::Vector3f& step) {
  Mesh mesh = test::cube();
  mesh.normals.assign(mesh.positions_m.size(), Eigen::Vector3f::UnitY());
  const Mesh first = mesh;
  for (const Eigen::Vector3f& p : first.positions_m) {
    mesh.positions_m.push_back(p + 2 * step);
    mesh.normals.emplace_back(0, 1, 0);
  }
  for (const auto& [a, b, c] : first.triangles) mesh.triangles.emplace_back(a + 8, b + 8, c + 8);
  return mesh;
}

TEST_P(GlbParts, SurfacesThatTouchInAPointStayTwo) {
  const Mesh mesh = touching_cubes({1, 1, 1}), whole = read_back(glb_of(mesh, config(), mesh.positions_m.size()));
  for (const std::size_t most : {3u, 4u, 6u, 10u}) {
    SCOPED_TRACE(most);
    expect_same_surface(read_back(glb_of(mesh, config(), most)), whole);
  }
}

/// Here the edges do not say whose they are: it may stay open along them, but no vertex may get more than one fan.
TEST_P(GlbParts, SurfacesThatTouchAlongAnEdgeDoNotGrowTogether) {
  const Mesh mesh = touching_cubes({1, 1, 0}), whole = read_back(glb_of(mesh, config(), mesh.positions_m.size()));
  for (const std::size_t most : {3u, 4u, 6u, 10u}) {
    SCOPED_TRACE(most);
    const Mesh again = read_back(glb_of(mesh, config(), most));
    const MeshCheck check = check_mesh(again);
    EXPECT_TRUE(facets(again) == facets(whole));
    EXPECT_EQ(check.non_manifold_edges, 0u);
    EXPECT_EQ(check.misoriented_edges, 0u);
    EXPECT_GE(check.vertices, mesh.positions_m.size());
  }
}

INSTANTIATE_TEST_SUITE_P(EveryPacking, GlbParts, ::testing::Range(0, 4));

TEST(GlbPartsLimits, AMeshWithinTheLimitIsOnePrimitiveWithAllItsVertices) {
  Mesh mesh = test::marked_sphere();
  mesh.positions_m.emplace_back(0, 0, 0);  // of no triangle
  mesh.normals.emplace_back(1, 0, 0);
  mesh.colours.push_back({1, 2, 3});
  const std::string glb = glb_of(mesh, {}, mesh.positions_m.size());
  EXPECT_EQ(json_of(glb)["meshes"][0]["primitives"].size(), 1u);
  EXPECT_EQ(glb, glb_of(mesh, {}, kMaxVerticesOfAPrimitive));
  EXPECT_EQ(read_back(glb).positions_m.size(), mesh.positions_m.size());
}

TEST(GlbPartsLimits, WhatTheCopiesOnTheBordersAddCountsForTheFilesLimit) {
  const Mesh mesh = test::marked_sphere();
  const TemporaryFolder folder;
  const Placement as_it_is;
  const auto is_written = [&](ExportConfig config, std::size_t most_vertices, std::uint64_t max_bytes) {
    config.max_vertices_of_a_primitive = most_vertices;
    auto file = AtomicFile::create(folder / "m.glb");
    const auto written = write_glb({mesh, as_it_is}, config, *file, max_bytes);
    if (!written) {
      EXPECT_NE(written.error().message.find("write PLY"), std::string::npos);
    }
    return static_cast<bool>(written);
  };
  ExportConfig compressed;
  compressed.compress = true;
  const std::uint64_t bytes = 32 * mesh.positions_m.size() + 12 * mesh.triangles.size();
  constexpr std::uint64_t kHead = 8192;
  for (const ExportConfig& config : {ExportConfig{}, compressed}) {
    EXPECT_TRUE(is_written(config, kMaxVerticesOfAPrimitive, bytes + kHead));
    EXPECT_FALSE(is_written(config, 20, bytes + kHead));
    EXPECT_TRUE(is_written(config, 20, 10 * bytes));
  }
}

TEST(GlbPartsLimits, EveryTruncationIsRefused) {
  const std::string glb = glb_of(test::small_mesh(), {}, 3);
  ASSERT_GT(json_of(glb)["meshes"][0]["primitives"].size(), 1u);
  for (std::size_t length = 0; length < glb.size(); ++length) {
    EXPECT_FALSE(parse_mesh(glb.substr(0, length), MeshFormat::kGlb, {})) << length;
  }
}

}  // namespace
}  // namespace scanknit
