#include "tests/export/read_tileset.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "export/mesh/read_mesh.h"
#include "tests/core/temporary_folder.h"

namespace scanknit::test {
namespace {

using Json = nlohmann::json;

constexpr double kRounding = 1e-12;  // of the doubles of a box's centre and half axes

void expect_keys(const Json& json, const std::set<std::string>& required, const std::set<std::string>& allowed) {
  ASSERT_TRUE(json.is_object()) << json.dump().substr(0, 200);
  for (const std::string& key : required) EXPECT_TRUE(json.contains(key)) << key;
  for (const auto& [key, value] : json.items()) EXPECT_TRUE(required.contains(key) || allowed.contains(key)) << key;
}

Eigen::AlignedBox3d box_of(const Json& volume) {
  expect_keys(volume, {"box"}, {});
  const auto values = volume.at("box").get<std::vector<double>>();
  EXPECT_EQ(values.size(), 12u);
  const Eigen::Vector3d centre(values[0], values[1], values[2]);
  const Eigen::Vector3d half(values[3], values[7], values[11]);
  for (const std::size_t other : {4, 5, 6, 8, 9, 10}) EXPECT_EQ(values[other], 0);
  EXPECT_GT(half.minCoeff(), 0);
  return {centre - half, centre + half};
}

Eigen::Vector3f z_up(const Eigen::Vector3f& p) {
  return {p.x(), -p.z() + 0.0F, p.y()};
}

ReadTile read_tile(const Json& json, const std::filesystem::path& folder, bool is_root) {
  expect_keys(json, {"boundingVolume", "geometricError", "content"}, {"children", "refine", "transform"});
  EXPECT_EQ(is_root, json.contains("refine"));  // the others have the root's
  ReadTile tile;
  tile.error_m = json.at("geometricError").get<double>();
  EXPECT_GE(tile.error_m, 0);
  tile.box = box_of(json.at("boundingVolume"));
  expect_keys(json.at("content"), {"uri"}, {});
  tile.uri = json.at("content").at("uri").get<std::string>();
  auto mesh = read_mesh(folder / tile.uri);
  EXPECT_TRUE(mesh) << tile.uri;
  if (!mesh) return tile;
  tile.mesh = *std::move(mesh);
  const double slack = kRounding * tile.box.sizes().maxCoeff();
  for (Eigen::Vector3f& p : tile.mesh.positions_m) {
    p = z_up(p);
    EXPECT_LE(tile.box.exteriorDistance(p.cast<double>()), slack) << tile.uri;
  }
  for (Eigen::Vector3f& n : tile.mesh.normals) n = z_up(n);
  if (!json.contains("children")) return tile;
  EXPECT_FALSE(json.at("children").empty());
  for (const Json& child : json.at("children")) {
    tile.children.push_back(read_tile(child, folder, false));
    const ReadTile& last = tile.children.back();
    EXPECT_LE(last.error_m, tile.error_m) << last.uri;
    EXPECT_LE(tile.box.exteriorDistance(last.box.min()), slack) << last.uri;
    EXPECT_LE(tile.box.exteriorDistance(last.box.max()), slack) << last.uri;
  }
  return tile;
}

}  // namespace

ReadTile read_tileset(const std::filesystem::path& folder) {
  const Json json = Json::parse(read_text(folder / "tileset.json"));
  expect_keys(json, {"asset", "geometricError", "root"}, {"extensionsUsed", "extensions"});
  expect_keys(json.at("asset"), {"version"}, {"extras"});
  EXPECT_EQ(json.at("asset").at("version"), "1.1");
  EXPECT_EQ(json.at("root").at("refine"), "REPLACE");
  ReadTile root = read_tile(json.at("root"), folder, true);
  EXPECT_GE(json.at("geometricError").get<double>(), root.error_m);
  return root;
}

}  // namespace scanknit::test
