// 3D Tiles: the mesh in leaves, coarser tiles above them, no gap wherever one tile takes the place of others.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <set>

#include "export/placement_plan.h"
#include "export/tiles/tileset_json.h"
#include "export/tiles/write_tiles.h"
#include "tests/core/temporary_folder.h"
#include "tests/export/export_samples.h"
#include "tests/export/read_tileset.h"
#include "tests/export/tiny_disk.h"

namespace scanknit {
namespace {

using nlohmann::literals::operator""_json_pointer;
using test::ReadTile;
using test::TemporaryFolder;
using test::TinyDisk;

constexpr std::size_t kMost = 1000;

/// A torus of 48,000 triangles with bumps, coloured by place.
Mesh bumpy_torus() {
  Mesh mesh = test::torus(240, 100);
  for (Eigen::Vector3f& p : mesh.positions_m) {
    mesh.colours.push_back(
        {static_cast<std::uint8_t>(100 + 70 * p.x()), 90, static_cast<std::uint8_t>(128 + 300 * p.z())});
    p *= 1 + 0.02F * std::sin(31 * p.x()) * std::sin(27 * p.y() + 1) * std::cos(23 * p.z());
  }
  return mesh;
}

/// Several holes, each over several tiles.
Mesh torn_torus() {
  Mesh mesh = bumpy_torus();
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const Eigen::Vector3f p = mesh.positions_m[t[0]];
    return std::sin(6 * p.x()) + std::sin(7 * p.y()) > 1.2F;
  });
  return mesh;
}

Result<WrittenFile> write(const Mesh& mesh, const std::filesystem::path& folder, std::size_t most = kMost,
                          const ExportConfig& config = {}, UpAxis up = UpAxis::kZ) {
  return write_tiles(mesh, plan_placement(MeshFormat::kTiles, config, up, std::nullopt), config, folder, most);
}

using Bits = std::array<std::uint32_t, 3>;
using Corners = std::array<Bits, 3>;

Bits bits(const Eigen::Vector3f& p) {
  const Eigen::Vector3f no_minus_zero = p + Eigen::Vector3f::Zero();
  return {std::bit_cast<std::uint32_t>(no_minus_zero.x()), std::bit_cast<std::uint32_t>(no_minus_zero.y()),
          std::bit_cast<std::uint32_t>(no_minus_zero.z())};
}

/// The triangles of a mesh by the bits of their positions, each from its smallest corner on; sorted.
std::vector<Corners> triangles_of(const Mesh& mesh) {
  std::vector<Corners> all;
  for (const Triangle& t : mesh.triangles) {
    Corners corners{bits(mesh.positions_m[t[0]]), bits(mesh.positions_m[t[1]]), bits(mesh.positions_m[t[2]])};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    all.push_back(corners);
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// How often each edge is passed one way rather than the other; without those that are passed both ways as often.
using Border = std::map<std::pair<Bits, Bits>, int>;

Border border_of(const std::vector<const Mesh*>& meshes) {
  Border border;
  for (const Mesh* mesh : meshes) {
    for (const Corners& c : triangles_of(*mesh)) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Bits &a = c[i], &b = c[(i + 1) % 3];
        border[a < b ? std::pair(a, b) : std::pair(b, a)] += a < b ? 1 : -1;
      }
    }
  }
  std::erase_if(border, [](const auto& edge) { return edge.second == 0; });
  return border;
}

/// The tiles of a view in which each tile is divided as `divides` says.
std::vector<const Mesh*> cut(const ReadTile& tile, const std::function<bool()>& divides) {
  if (tile.children.empty() || !divides()) return {&tile.mesh};
  std::vector<const Mesh*> meshes;
  for (const ReadTile& child : tile.children) {
    const auto below = cut(child, divides);
    meshes.insert(meshes.end(), below.begin(), below.end());
  }
  return meshes;
}

std::vector<const Mesh*> leaves_of(const ReadTile& root) {
  return cut(root, [] { return true; });
}

void for_each_tile(const ReadTile& tile, const std::function<void(const ReadTile&, int)>& visit, int depth = 0) {
  visit(tile, depth);
  for (const ReadTile& child : tile.children) for_each_tile(child, visit, depth + 1);
}

std::map<std::string, std::string> bytes_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files[entry.path().filename().string()] = test::read_text(entry.path());
  }
  return files;
}

TEST(Tiles, LeavesHaveTheTrianglesOfTheMesh) {
  const TemporaryFolder folder;
  for (const Mesh& mesh : {bumpy_torus(), torn_torus()}) {
    ASSERT_TRUE(write(mesh, folder / "m.tiles"));
    const ReadTile root = test::read_tileset(folder / "m.tiles");
    std::vector<Corners> triangles;
    for (const Mesh* leaf : leaves_of(root)) {
      EXPECT_LE(leaf->triangles.size(), kMost);
      const auto own = triangles_of(*leaf);
      triangles.insert(triangles.end(), own.begin(), own.end());
    }
    std::sort(triangles.begin(), triangles.end());
    EXPECT_EQ(triangles, triangles_of(mesh));
  }
}

TEST(Tiles, AnyMixOfLevelsOfAClosedMeshIsClosed) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write(bumpy_torus(), folder / "m.tiles"));
  const ReadTile root = test::read_tileset(folder / "m.tiles");
  EXPECT_EQ(border_of({&root.mesh}), Border());
  EXPECT_EQ(border_of(leaves_of(root)), Border());
  int mixed = 0;
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const std::uint32_t share = seed % 4 + 1;
    const auto meshes = cut(root, [&] { return random() % 5 < share; });
    mixed += meshes.size() > 8 ? 1 : 0;
    ASSERT_EQ(border_of(meshes), Border()) << "seed " << seed;
  }
  EXPECT_GT(mixed, 20);
}

// Its own holes are simplified, too; so the borders of two views differ, but only where there is no other tile: round
// holes, whose edges no two tiles have in common.
TEST(Tiles, NoMixOfLevelsOfAnOpenMeshHasABorderThatLeavesIt) {
  const TemporaryFolder folder;
  const Mesh mesh = torn_torus();
  ASSERT_TRUE(write(mesh, folder / "m.tiles"));
  const ReadTile root = test::read_tileset(folder / "m.tiles");
  std::set<Bits> rim;
  for (const auto& [edge, sides] : border_of({&mesh})) {
    rim.insert(edge.first);
    rim.insert(edge.second);
  }
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    const std::uint32_t share = seed % 4 + 1;
    for (const auto& [edge, sides] : border_of(cut(root, [&] { return random() % 5 < share; }))) {
      ASSERT_TRUE(rim.contains(edge.first) && rim.contains(edge.second)) << "seed " << seed;
    }
  }
  EXPECT_LT(border_of({&root.mesh}).size(), border_of({&mesh}).size() / 2);
}

TEST(Tiles, EveryLevelHasFewerTrianglesAndALargerError) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write(bumpy_torus(), folder / "m.tiles"));
  const ReadTile root = test::read_tileset(folder / "m.tiles");
  int deepest = 0;
  for_each_tile(root, [&](const ReadTile& tile, int depth) {
    deepest = std::max(deepest, depth);
    EXPECT_EQ(tile.children.empty(), tile.error_m == 0) << tile.uri;
    std::size_t below = 0;
    for (const ReadTile& child : tile.children) {
      below += child.mesh.triangles.size();
      EXPECT_GT(tile.error_m, child.error_m);
    }
    if (!tile.children.empty()) {
      EXPECT_LT(tile.mesh.triangles.size(), below) << tile.uri;
    }
  });
  EXPECT_GE(deepest, 3);
  EXPECT_LE(root.mesh.triangles.size(), kMost + kMost / 50);
}

// The vertices of the coarsest tile are those of the mesh; so are places on its triangles, within its error.
TEST(Tiles, GeometricErrorIsTheDistanceOfTheCoarseMeshInMetres) {
  const TemporaryFolder folder;
  Mesh mesh = test::torus(240, 100);
  ASSERT_TRUE(write(mesh, folder / "m.tiles"));
  const ReadTile root = test::read_tileset(folder / "m.tiles");
  double farthest = 0;
  for (const Triangle& t : root.mesh.triangles) {
    const Eigen::Vector3d p =
        (root.mesh.positions_m[t[0]] + root.mesh.positions_m[t[1]] + root.mesh.positions_m[t[2]]).cast<double>() / 3;
    const double from_ring = std::hypot(p.x(), p.y()) - 1;
    farthest = std::max(farthest, std::abs(std::hypot(from_ring, p.z()) - 0.3));
  }
  EXPECT_LT(farthest, 2 * root.error_m);
  EXPECT_LT(root.error_m, 8 * farthest);
}

// A chessboard has no shape that a simplifier would keep. A corner of a square may be cut, but not many.
TEST(Tiles, FlatPatternsStayAndCountAsErrors) {
  const TemporaryFolder folder;
  constexpr std::uint32_t kSide = 161;
  constexpr float kStep = 0.01F;
  const auto colour_at = [](const Eigen::Vector3f& p) {
    const auto square = [](float x) { return static_cast<int>(std::floor(x / (20 * kStep))); };
    return (square(p.x()) + square(p.y())) % 2 == 0 ? Rgb8{230, 230, 230} : Rgb8{20, 20, 20};
  };
  Mesh mesh;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    mesh.positions_m.emplace_back(kStep * static_cast<float>(i % kSide), kStep * static_cast<float>(i / kSide), 0.0F);
    mesh.normals.emplace_back(0, 0, 1);
    mesh.colours.push_back(colour_at(mesh.positions_m.back()));
    if (i % kSide == 0 || i < kSide) continue;
    mesh.triangles.emplace_back(i - kSide - 1, i - kSide, i);
    mesh.triangles.emplace_back(i - kSide - 1, i, i - 1);
  }
  ASSERT_TRUE(write(mesh, folder / "m.tiles", 8000));
  const ReadTile root = test::read_tileset(folder / "m.tiles");
  EXPECT_GT(root.error_m, 0);
  double area = 0, wrong = 0;
  for (const Triangle& t : root.mesh.triangles) {
    const Eigen::Vector3f &a = root.mesh.positions_m[t[0]], &b = root.mesh.positions_m[t[1]],
                          &c = root.mesh.positions_m[t[2]];
    const auto own = static_cast<double>((b - a).cross(c - a).norm()) / 2;
    area += own;
    const Rgb8 seen = root.mesh.colours[t[0]];
    if (!(seen == colour_at((a + b + c) / 3))) wrong += own;
  }
  constexpr double kFolded = 0.02;  // of the area: meshoptimizer folds some triangles over others, in the plane
  EXPECT_NEAR(area, 1.6 * 1.6, kFolded * area);
  EXPECT_LT(wrong / area, 0.1);
}

TEST(Tiles, AreUprightInMetresAndKeepColoursAndNormals) {
  const TemporaryFolder folder;
  const Mesh mesh = test::marked_sphere();
  const std::map<UpAxis, int> caps = {{UpAxis::kX, 0}, {UpAxis::kY, 1}, {UpAxis::kZ, 2}};
  const std::array colours = {Rgb8{200, 60, 40}, Rgb8{60, 180, 75}, Rgb8{40, 90, 200}};
  for (const auto& [up, axis] : caps) {
    ASSERT_TRUE(write(mesh, folder / "m.tiles", kMost, {}, up));
    const ReadTile root = test::read_tileset(folder / "m.tiles");
    for_each_tile(root, [&](const ReadTile& tile, int) {
      ASSERT_EQ(tile.mesh.colours.size(), tile.mesh.positions_m.size());
      for (std::size_t v = 0; v < tile.mesh.positions_m.size(); ++v) {
        const bool is_top = tile.mesh.colours[v] == colours[static_cast<std::size_t>(axis)];
        EXPECT_EQ(is_top, tile.mesh.positions_m[v].z() > 0.8F);
        EXPECT_LT((tile.mesh.positions_m[v] - tile.mesh.normals[v]).norm(), 1e-5F);
      }
    });
    EXPECT_NEAR(root.box.min().z(), -1, 1e-6);
  }
}

TEST(Tiles, OfAVolumeInMillimetresAreInMetres) {
  const TemporaryFolder folder;
  const ExportConfig config;
  ASSERT_TRUE(write_tiles(bumpy_torus(), plan_placement(MeshFormat::kTiles, config, UpAxis::kZ, 1e-3), config,
                          folder / "mm.tiles", kMost));
  ASSERT_TRUE(write(bumpy_torus(), folder / "m.tiles"));
  const ReadTile small = test::read_tileset(folder / "mm.tiles"), large = test::read_tileset(folder / "m.tiles");
  EXPECT_NEAR(small.error_m / large.error_m, 1e-3, 1e-9);
  EXPECT_NEAR(small.box.max().x() / large.box.max().x(), 1e-3, 1e-9);
}

TEST(Tiles, SmallMeshIsOneTile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_mesh(test::cube(), folder / "m.tiles", {}, UpAxis::kZ));
  EXPECT_TRUE(test::read_tileset(folder / "m.tiles").children.empty());
  EXPECT_EQ(bytes_of(folder / "m.tiles").size(), 2u);
}

TEST(Tiles, FlatMeshHasABoxWithAThickness) {
  const TemporaryFolder folder;
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  ASSERT_TRUE(write(mesh, folder / "m.tiles"));
  EXPECT_GT(test::read_tileset(folder / "m.tiles").box.sizes().minCoeff(), 0);
}

// Nothing can divide them: one leaf has them all.
TEST(Tiles, TrianglesInOnePlaceAreOneTile) {
  const TemporaryFolder folder;
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles.assign(20, {0, 1, 2});
  ASSERT_TRUE(write(mesh, folder / "m.tiles", 4));
  EXPECT_EQ(test::read_tileset(folder / "m.tiles").mesh.triangles.size(), 20u);
}

TEST(Tiles, CompressedAreTheSameMeshes) {
  const TemporaryFolder folder;
  ExportConfig config;
  config.compress = true;
  config.quantize = true;  // has no effect: each tile would have its own grid
  ASSERT_TRUE(write(bumpy_torus(), folder / "packed.tiles", kMost, config));
  ASSERT_TRUE(write(bumpy_torus(), folder / "plain.tiles"));
  const ReadTile packed = test::read_tileset(folder / "packed.tiles"),
                 plain = test::read_tileset(folder / "plain.tiles");
  EXPECT_EQ(triangles_of(packed.mesh), triangles_of(plain.mesh));
  const auto json = nlohmann::json::parse(test::read_text(folder / "packed.tiles" / "tileset.json"));
  EXPECT_EQ(json.at("/extensions/3DTILES_content_gltf/extensionsRequired/0"_json_pointer), "EXT_meshopt_compression");
  const auto one = leaves_of(packed), other = leaves_of(plain);
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(triangles_of(*one[i]), triangles_of(*other[i]));
}

TEST(Tiles, HaveTheSameBytesForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  std::vector<std::map<std::string, std::string>> written;
  for (const std::size_t threads : {1, 2, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    ASSERT_TRUE(write(bumpy_torus(), folder / "m.tiles"));
    written.push_back(bytes_of(folder / "m.tiles"));
  }
  EXPECT_EQ(written[0], written[1]);
  EXPECT_EQ(written[0], written[2]);
}

TEST(Tiles, ReplaceOlderTilesAsAWhole) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write(bumpy_torus(), folder / "m.tiles"));
  ASSERT_TRUE(check_tiles_writable(folder / "m.tiles"));
  const auto written = write(test::cube(), folder / "m.tiles");
  ASSERT_TRUE(written);
  const auto files = bytes_of(folder / "m.tiles");
  EXPECT_EQ(files.size(), 2u);
  EXPECT_EQ(written->bytes, files.at("r.glb").size() + files.at("tileset.json").size());
  EXPECT_EQ(written->convention, "metres, Z up");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(Tiles, NeverReplaceAFolderOfOtherFiles) {
  const TemporaryFolder folder;
  test::write_text(folder / "m.tiles" / "photo.jpg", "x");
  test::write_text(folder / "file.tiles", "x");
  for (const char* name : {"m.tiles", "file.tiles"}) {
    const auto written = write(test::cube(), folder / name);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::kOutput);
    EXPECT_EQ(check_tiles_writable(folder / name).error().message, written.error().message);
  }
  EXPECT_EQ(test::read_text(folder / "m.tiles" / "photo.jpg"), "x");
  EXPECT_EQ(folder.entries(), 2u);
}

TEST(Tiles, FullDiskKeepsTheOldTilesAndLeavesNothingElse) {
  const TemporaryFolder folder;
  const TinyDisk disk(folder.path());
  if (!disk.is_mounted()) GTEST_SKIP() << "SKIPPED: a tiny file system needs root";
  ASSERT_TRUE(write(test::cube(), folder / "m.tiles"));
  const auto old = bytes_of(folder / "m.tiles");
  const auto written = write(bumpy_torus(), folder / "m.tiles", 200);  // some tiles fit
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kOutput);
  EXPECT_EQ(written.error().where, (folder / "m.tiles").string());
  EXPECT_NE(written.error().message.find("No space left"), std::string::npos) << written.error().message;
  EXPECT_EQ(bytes_of(folder / "m.tiles"), old);
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(Georeference, IsEastNorthUpOnTheEllipsoid) {
  const Eigen::Isometry3d at_zero = T_earth_local(0, 0, 10);
  EXPECT_LT((at_zero.translation() - Eigen::Vector3d(6378147, 0, 0)).norm(), 1e-8);
  EXPECT_LT((at_zero.linear().col(0) - Eigen::Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_LT((at_zero.linear().col(1) - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  const Eigen::Isometry3d at_pole = T_earth_local(30, 90, 0);
  EXPECT_LT((at_pole.translation() - Eigen::Vector3d(0, 0, 6356752.314245179)).norm(), 1e-8);
  EXPECT_LT((at_pole.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  const Eigen::Isometry3d berlin = T_earth_local(13.4, 52.5, 80);
  EXPECT_NEAR(berlin.linear().determinant(), 1, 1e-15);
  EXPECT_LT((T_earth_local(13.4, 52.5, 81).translation() - berlin * Eigen::Vector3d(0, 0, 1)).norm(), 1e-8);
  const Eigen::Vector3d towards_north = T_earth_local(13.4, 52.500009, 80).translation();  // a metre
  EXPECT_NEAR((berlin.inverse() * towards_north).y(), 1, 0.01);
  const Eigen::Vector3d towards_east = T_earth_local(13.40001473, 52.5, 80).translation();
  EXPECT_NEAR((berlin.inverse() * towards_east).x(), 1, 0.01);
}

TEST(Georeference, IsTheTransformOfTheRootByColumns) {
  const TemporaryFolder folder;
  ExportConfig config;
  config.georeference = {13.4, 52.5, 80};
  ASSERT_TRUE(write(bumpy_torus(), folder / "m.tiles", kMost, config));
  (void)test::read_tileset(folder / "m.tiles");
  const auto json = nlohmann::json::parse(test::read_text(folder / "m.tiles" / "tileset.json"));
  const auto values = json.at("root").at("transform").get<std::vector<double>>();
  ASSERT_EQ(values.size(), 16u);
  EXPECT_EQ(Eigen::Matrix4d(Eigen::Map<const Eigen::Matrix4d>(values.data())), T_earth_local(13.4, 52.5, 80).matrix());
  ASSERT_TRUE(write(bumpy_torus(), folder / "nowhere.tiles"));
  EXPECT_EQ(test::read_text(folder / "nowhere.tiles" / "tileset.json").find("transform"), std::string::npos);
}

}  // namespace
}  // namespace scanknit
