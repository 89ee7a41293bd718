#include "measure/mesh_unit.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace scanknit {

const NamedMeshUnit& description_of(MeshUnit unit) {
  for (const NamedMeshUnit& named : kMeshUnits) {
    if (named.unit == unit) return named;
  }
  SCANKNIT_CHECK(false);
}

void to_metres(Mesh& mesh, MeshUnit unit) {
  if (unit == MeshUnit::kMetre) return;
  const double metres = description_of(unit).metres;
  for (Eigen::Vector3f& p : mesh.positions_m) p = (metres * p.cast<double>()).cast<float>();
}

double diagonal_m(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) box.extend(mesh.positions_m[v].cast<double>());
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

namespace {

double factor_between(double a, double b) {
  return std::max(a / b, b / a);
}

}  // namespace

bool differ_as_inch_and_millimetre(double diagonal_m, double other_diagonal_m) {
  constexpr double kMillimetresPerInch = 25.4, kAlike = 1.1;
  if (!(diagonal_m > 0 && other_diagonal_m > 0)) return false;
  return factor_between(factor_between(diagonal_m, other_diagonal_m), kMillimetresPerInch) <= kAlike;
}

std::optional<MeshUnit> unit_that_fits(double diagonal_m, double other_diagonal_m, MeshUnit assumed) {
  constexpr double kSurprising = 5, kAlike = 1.25;
  if (!(diagonal_m > 0 && other_diagonal_m > 0)) return std::nullopt;
  if (factor_between(diagonal_m, other_diagonal_m) < kSurprising) return std::nullopt;
  for (const NamedMeshUnit& named : kMeshUnits) {
    if (named.unit == assumed) continue;
    const double rescaled_m = other_diagonal_m * named.metres / description_of(assumed).metres;
    if (factor_between(diagonal_m, rescaled_m) <= kAlike) return named.unit;
  }
  return std::nullopt;
}

}  // namespace scanknit
