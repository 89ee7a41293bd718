// What `distance` prints of two meshes: JSON, or lines to read.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/measure/align_meshes.h"
#include "measure/compare/compare_meshes.h"

namespace scanknit {

struct ComparedFile {
  std::filesystem::path path;
  MeshUnit unit = MeshUnit::kMetre;
  std::size_t vertices = 0, triangles = 0;
};

struct Comparison {
  ComparedFile mesh, reference;
  MeshAlignment alignment = MeshAlignment::kGiven;
  MeshPlacement placement;
  ComparedMeshes compared;
  std::optional<double> tolerance_m;
  double allowed_share = 0;
  std::vector<std::filesystem::path> files;  ///< that were written

  /// Nothing without a tolerance.
  [[nodiscard]] std::optional<bool> is_within_tolerance() const;
};

[[nodiscard]] std::string comparison_json(const Comparison& comparison);
[[nodiscard]] std::string comparison_lines(const Comparison& comparison);

/// "0.05 mm": a length for people.
[[nodiscard]] std::string in_millimetres(double metres);

/// "x 0 to 10, y -5 to 5, z 0 to 20 mm"
[[nodiscard]] std::string extent_words(const Eigen::AlignedBox3d& box_m);

}  // namespace scanknit
