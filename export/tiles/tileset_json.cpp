#include "export/tiles/tileset_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "core/version.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kContentExtension = "3DTILES_content_gltf";
constexpr double kEquatorM = 6378137.0, kFlattening = 1 / 298.257223563;  // WGS 84 (NGA.STND.0036, table 3.1)
constexpr double kThinnestM = 1e-6;                                       // half of a flat box: viewers divide by it

/// 3D Tiles 1.1, "glTF transforms": y-up content is turned to z-up by a quarter turn about x.
Eigen::Vector3d z_up(const Eigen::Vector3d& p) {
  return {p.x(), -p.z(), p.y()};
}

Json box_json(const Eigen::AlignedBox3f& box) {
  const Eigen::AlignedBox3d wide = box.cast<double>();
  const Eigen::Vector3d centre = z_up(wide.center());
  const Eigen::Vector3d half = z_up(wide.sizes() / 2).cwiseAbs().cwiseMax(kThinnestM);
  const Json values = {
      centre.x() + 0.0, centre.y() + 0.0, centre.z() + 0.0, half.x(), 0.0, 0.0, 0.0, half.y(), 0.0, 0.0, 0.0, half.z()};
  return {{"box", values}};
}

Json tile_json(const WrittenTile& tile) {
  Json json = {{"boundingVolume", box_json(tile.box)}, {"geometricError", tile.error_m}};
  json["content"] = {{"uri", tile.uri}};
  for (const WrittenTile& child : tile.children) json["children"].push_back(tile_json(child));
  return json;
}

Json columns(const Eigen::Isometry3d& transform) {
  Json values = Json::array();
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) values.push_back(transform.matrix()(row, column));
  }
  return values;
}

}  // namespace

Eigen::Isometry3d T_earth_local(double longitude_deg, double latitude_deg, double height_m) {
  constexpr double kDegree = std::numbers::pi / 180;
  const double sin_lon = std::sin(longitude_deg * kDegree), cos_lon = std::cos(longitude_deg * kDegree);
  const double sin_lat = std::sin(latitude_deg * kDegree), cos_lat = std::cos(latitude_deg * kDegree);
  const double e2 = kFlattening * (2 - kFlattening);                          // first eccentricity, squared
  const double normal_m = kEquatorM / std::sqrt(1 - e2 * sin_lat * sin_lat);  // radius of the prime vertical
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear().col(0) = Eigen::Vector3d(-sin_lon, cos_lon, 0);
  T.linear().col(1) = Eigen::Vector3d(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat);
  T.linear().col(2) = Eigen::Vector3d(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
  T.translation() =
      Eigen::Vector3d((normal_m + height_m) * cos_lat * cos_lon, (normal_m + height_m) * cos_lat * sin_lon,
                      (normal_m * (1 - e2) + height_m) * sin_lat);
  return T;
}

std::string tileset_json(const WrittenTile& root, std::size_t triangles, const ExportConfig& config) {
  Json json;
  json["asset"]["version"] = "1.1";
  json["asset"]["extras"] = {{"generator", fmt::format("ScanKnit {}", kVersion)}, {"triangles", triangles}};
  if (config.compress) {  // viewers may know before they load a tile
    const Json used = Json::array({"EXT_meshopt_compression"});
    json["extensionsUsed"] = Json::array({kContentExtension});
    json["extensions"][kContentExtension] = {{"extensionsUsed", used}, {"extensionsRequired", used}};
  }
  // Of showing nothing: the whole size. Viewers begin with the root where that is more than they allow.
  json["geometricError"] = std::max(root.error_m, static_cast<double>(root.box.sizes().norm()));
  json["root"] = tile_json(root);
  json["root"]["refine"] = "REPLACE";
  const Georeference& place = config.georeference;
  if (place.longitude_deg && place.latitude_deg) {
    json["root"]["transform"] = columns(T_earth_local(*place.longitude_deg, *place.latitude_deg, place.height_m));
  }
  return json.dump(1) + "\n";
}

}  // namespace scanknit
