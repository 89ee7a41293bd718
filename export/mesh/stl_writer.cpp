#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cstring>

#include "core/version.h"
#include "export/mesh/byte_writer.h"
#include "export/mesh/mesh_writers.h"

namespace scanknit {
namespace {

Eigen::Vector3f facet_normal(const std::array<Eigen::Vector3f, 3>& corners) {
  const Eigen::Vector3d a = corners[0].cast<double>();
  const Eigen::Vector3d n = (corners[1].cast<double>() - a).cross(corners[2].cast<double>() - a);
  const double length = n.norm();
  if (!(length > 0)) return Eigen::Vector3f::Zero();  // a triangle without area; readers then use their own
  return (n / length).cast<float>();
}

}  // namespace

std::string stl_head(const Placement& placement) {
  constexpr std::size_t kBytes = 80;  // free text that must not begin with "solid", the mark of ASCII STL
  std::string head = fmt::format("ScanKnit {} binary STL, {}, Z up", kVersion, placement.unit);
  head.resize(kBytes, ' ');
  return head;
}

void put_stl_facet(const std::array<Eigen::Vector3f, 3>& corners, ByteWriter& out) {
  out.put(facet_normal(corners));
  for (const Eigen::Vector3f& corner : corners) out.put(corner);
  out.put(std::uint16_t{0});  // attribute byte count: unused
}

Result<void> write_stl(const Mesh& mesh, const Placement& placement, AtomicFile& file) {
  ByteWriter out(file);
  out.text(stl_head(placement));
  out.put(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    put_stl_facet({placement.position(mesh.positions_m[t[0]]), placement.position(mesh.positions_m[t[1]]),
                   placement.position(mesh.positions_m[t[2]])},
                  out);
  }
  return out.finish();
}

}  // namespace scanknit
