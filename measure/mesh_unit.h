// The unit of a mesh file's numbers, and whether two meshes seem to differ by one.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "core/mesh.h"

namespace scanknit {

enum class MeshUnit { kMillimetre, kCentimetre, kInch, kMetre };

struct NamedMeshUnit {
  MeshUnit unit;
  std::string_view name, plural;
  double metres;
};
inline constexpr std::array<NamedMeshUnit, 4> kMeshUnits = {{
    {MeshUnit::kMillimetre, "mm", "millimetres", 0.001},
    {MeshUnit::kCentimetre, "cm", "centimetres", 0.01},
    {MeshUnit::kInch, "inch", "inches", 0.0254},
    {MeshUnit::kMetre, "m", "metres", 1},
}};

[[nodiscard]] const NamedMeshUnit& description_of(MeshUnit unit);

/// Scales the positions to metres.
void to_metres(Mesh& mesh, MeshUnit unit);

/// The length of the bounding box's diagonal.
[[nodiscard]] double diagonal_m(const Mesh& mesh);

/// Two meshes of one thing, of which `other` was read as if its numbers had the unit `assumed`. If their diagonals
/// differ more than fivefold, and another unit would bring them within a quarter of each other: that unit.
[[nodiscard]] std::optional<MeshUnit> unit_that_fits(double diagonal_m, double other_diagonal_m, MeshUnit assumed);

/// Whether two diagonals differ by a factor within a tenth of 25.4, whichever is larger.
[[nodiscard]] bool differ_as_inch_and_millimetre(double diagonal_m, double other_diagonal_m);

}  // namespace scanknit
