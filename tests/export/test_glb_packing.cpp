// Smaller GLB files, read back by our own reader.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "export/mesh/mesh_readers.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

enum class Packing { kPlain, kQuantized, kCompressed, kBoth };

ExportConfig config_of(Packing packing) {
  ExportConfig config;
  config.quantize = packing == Packing::kQuantized || packing == Packing::kBoth;
  config.compress = packing == Packing::kCompressed || packing == Packing::kBoth;
  return config;
}

std::string written(const Mesh& mesh, Packing packing) {
  const TemporaryFolder folder;
  const auto file = write_mesh(mesh, folder / "m.glb", config_of(packing), UpAxis::kY);
  EXPECT_TRUE(file) << file.error().text();
  return test::read_text(folder / "m.glb");
}

Mesh read_back(const std::string& glb) {
  const auto mesh = parse_mesh(glb, MeshFormat::kGlb, {});
  EXPECT_TRUE(mesh) << mesh.error().text();
  return mesh ? *mesh : Mesh{};
}

Mesh with_normals(Mesh mesh) {
  mesh.normals.clear();
  for (const Eigen::Vector3f& p : mesh.positions_m) mesh.normals.push_back(p.normalized());
  return mesh;
}

using Corner = std::array<float, 3>;
using Facet = std::array<std::pair<Corner, std::array<int, 3>>, 3>;

/// The triangles as sets of coloured corners in their order, from the least corner on: whatever the order of vertices.
std::multiset<Facet> facets(const Mesh& mesh) {
  std::multiset<Facet> all;
  for (const Triangle& t : mesh.triangles) {
    Facet facet;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3f& p = mesh.positions_m[t[i]];
      const Rgb8 c = mesh.colours[t[i]];
      facet[i] = {{p.x(), p.y(), p.z()}, {c.r, c.g, c.b}};
    }
    std::rotate(facet.begin(), std::min_element(facet.begin(), facet.end()), facet.end());
    all.insert(facet);
  }
  return all;
}

nlohmann::json json_of(const std::string& glb) {
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof(length));
  return nlohmann::json::parse(glb.substr(20, length));
}

TEST(GlbPacking, PlainIsTheDefaultAndNeedsNoExtension) {
  EXPECT_FALSE(ExportConfig{}.quantize || ExportConfig{}.compress);
  EXPECT_FALSE(json_of(written(test::marked_sphere(), Packing::kPlain)).contains("extensionsRequired"));
}

TEST(GlbPacking, CompressedIsTheSameMeshBitByBit) {
  const Mesh mesh = with_normals(test::marked_sphere());
  const Mesh again = read_back(written(mesh, Packing::kCompressed));
  EXPECT_EQ(again.positions_m.size(), mesh.positions_m.size());
  EXPECT_EQ(again.normals.size(), mesh.normals.size());
  EXPECT_TRUE(facets(again) == facets(mesh));
}

TEST(GlbPacking, QuantizedIsOffByHalfAStepOfTheLongestSide) {
  const Mesh mesh = with_normals(test::marked_sphere());
  const Mesh again = read_back(written(mesh, Packing::kQuantized));
  ASSERT_EQ(again.positions_m.size(), mesh.positions_m.size());
  constexpr float kHalfStep = 2.0f / 65535 / 2, kRounding = 1e-6f;  // the sphere is 2 wide
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    EXPECT_LE((again.positions_m[i] - mesh.positions_m[i]).cwiseAbs().maxCoeff(), kHalfStep + kRounding);
    EXPECT_GT(again.normals[i].dot(mesh.normals[i]), 0.9999f);
    EXPECT_EQ(again.colours[i], mesh.colours[i]);
  }
  EXPECT_TRUE(std::equal(again.triangles.begin(), again.triangles.end(), mesh.triangles.begin(), mesh.triangles.end()));
}

TEST(GlbPacking, BothIsTheQuantizedMesh) {
  const Mesh mesh = with_normals(test::marked_sphere());
  EXPECT_TRUE(facets(read_back(written(mesh, Packing::kBoth))) ==
              facets(read_back(written(mesh, Packing::kQuantized))));
}

TEST(GlbPacking, EachIsSmallerThanTheOneBefore) {
  const Mesh mesh = with_normals(test::marked_sphere());
  std::size_t before = written(mesh, Packing::kPlain).size();
  for (const Packing packing : {Packing::kQuantized, Packing::kCompressed, Packing::kBoth}) {
    const std::size_t bytes = written(mesh, packing).size();
    EXPECT_LT(bytes, before);
    before = bytes;
  }
}

TEST(GlbPacking, MeshesWithoutColoursNormalsOrExtentAndLooseVerticesCome) {
  Mesh loose = test::tetrahedron();
  loose.positions_m.emplace_back(7, 7, 7);
  Mesh point;
  point.positions_m.assign(3, Eigen::Vector3f(1, 2, 3));
  point.triangles = {{0, 1, 2}};
  for (const Packing packing : {Packing::kQuantized, Packing::kCompressed, Packing::kBoth}) {
    EXPECT_EQ(read_back(written(loose, packing)).positions_m.size(), 5u);
    const Mesh again = read_back(written(point, packing));
    ASSERT_EQ(again.positions_m.size(), 3u);
    EXPECT_EQ(again.positions_m[2], point.positions_m[2]);
  }
}

TEST(GlbPacking, IsTheSameBytesEveryTime) {
  const Mesh mesh = test::marked_sphere();
  EXPECT_EQ(written(mesh, Packing::kBoth), written(mesh, Packing::kBoth));
}

TEST(GlbPacking, EveryTruncationIsRefused) {
  const std::string glb = written(test::small_mesh(), Packing::kBoth);
  for (std::size_t length = 0; length < glb.size(); ++length) {
    EXPECT_FALSE(parse_mesh(glb.substr(0, length), MeshFormat::kGlb, {})) << length;
  }
}

TEST(GlbPacking, EveryDamagedByteIsAnswered) {
  const std::string glb = written(test::small_mesh(), Packing::kBoth);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < glb.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xFF}) {
      std::string damaged = glb;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      refused += parse_mesh(damaged, MeshFormat::kGlb, {}) ? 0 : 1;
    }
  }
  EXPECT_GT(refused, glb.size() / 2);
}

TEST(GlbPacking, WhatUnfoldsToMoreThanIsBelievedIsRefused) {
  Limits small;
  small.max_mesh_bytes = 100;
  const auto mesh = parse_mesh(written(test::marked_sphere(), Packing::kBoth), MeshFormat::kGlb, small);
  ASSERT_FALSE(mesh);
  EXPECT_NE(mesh.error().message.find("more than is believed"), std::string::npos) << mesh.error().message;
}

}  // namespace
}  // namespace scanknit
