// What `measure`, and `distance` with a mesh as the reference, are told.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "measure/mesh_unit.h"

namespace scanknit {

/// A length or a coordinate that was given with a unit, or as a plain number in the unit of the mesh file.
struct GivenLength {
  double value = 0;
  bool is_in_metres = false;

  [[nodiscard]] double metres(MeshUnit file_unit) const {
    return is_in_metres ? value : value * description_of(file_unit).metres;
  }
};

enum class MeshAlignment {
  kGiven,  ///< as the files, a matrix or pairs of points say
  kNear,   ///< from there the best fit
  kShape,  ///< found by the shapes alone
};

struct ComparisonArguments {
  MeshAlignment alignment = MeshAlignment::kGiven;
  std::optional<std::filesystem::path> pairs, matrix;
  std::optional<MeshUnit> mesh_unit, reference_unit;  ///< nothing: the format's
  std::optional<GivenLength> tolerance;
  double allowed_share = 0;      ///< of vertices and of area that may lie beyond the tolerance
  std::filesystem::path output;  ///< folder; empty: none

  [[nodiscard]] bool is_default() const {
    return alignment == MeshAlignment::kGiven && !pairs && !matrix && !mesh_unit && !reference_unit && !tolerance &&
           output.empty();
  }
};

using GivenPoint = std::array<GivenLength, 3>;

/// A plane: the points p with normal . p = the length; or the one through `point`, where that is given.
struct GivenPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  GivenLength offset;
  std::optional<GivenPoint> point;
};

struct MeasureArguments {
  std::filesystem::path mesh;
  std::optional<MeshUnit> unit;
  std::optional<GivenLength> thin;  ///< walls below this are thin
  std::vector<GivenPlane> sections;
  std::optional<GivenPoint> plane_at, circle_at;
  std::optional<GivenLength> radius;
  std::filesystem::path output;  ///< folder; empty: none
};

}  // namespace scanknit
