#include "export/measure/mesh_stats.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

namespace scanknit {
namespace {

/// The float's shortest decimal, so that 0.1f is printed as 0.1 and not as 0.10000000149011612.
double shortest(float value) {
  return std::isfinite(value) ? std::strtod(fmt::format("{}", value).c_str(), nullptr) : 0.0;
}

}  // namespace

std::string mesh_check_json(const MeshCheck& check) {
  const auto corner = [](const Eigen::Vector3f& p) {
    return nlohmann::ordered_json::array({shortest(p.x()), shortest(p.y()), shortest(p.z())});
  };
  nlohmann::ordered_json json;
  json["vertices"] = check.vertices;
  json["triangles"] = check.triangles;
  json["components"] = check.components;
  json["boundary_edges"] = check.boundary_edges;
  json["non_manifold_edges"] = check.non_manifold_edges;
  json["non_manifold_vertices"] = check.non_manifold_vertices;
  json["misoriented_edges"] = check.misoriented_edges;
  json["degenerate_triangles"] = check.degenerate_triangles;
  json["duplicate_triangles"] = check.duplicate_triangles;
  json["unreferenced_vertices"] = check.unreferenced_vertices;
  json["euler"] = check.euler;
  json["is_closed"] = check.is_closed();
  json["is_manifold"] = check.is_manifold();
  json["is_well_formed"] = check.is_well_formed;
  json["bounds_m"] = nlohmann::ordered_json::array({corner(check.min_m), corner(check.max_m)});
  return json.dump();
}

}  // namespace scanknit
