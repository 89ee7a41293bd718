// What the readers are given, and what they must see of it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace scanknit::test {

/// A ball with an arm along +x, +y and +z: red, green, blue, of three lengths, the ball nearly black. Extracted from
/// its signed distances, away from the origin; no turn and no mirror takes it to itself. Each vertex has a colour of
/// its own.
[[nodiscard]] Mesh jack();

/// A mesh as another program told it. Colours are as it keeps them, with 255 for 1; none where it keeps none.
struct ToldMesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d> colours;
  std::vector<Triangle> triangles;
};

enum class ToldColour {
  kNone,
  kSrgb,    ///< the camera's bytes, exactly
  kLinear,  ///< linear light, which encodes to these bytes exactly
};

enum class ToldVertices {
  kShared,    ///< as many as we have
  kSeparate,  ///< three for each triangle
  kAny,       ///< joined by a rule of the reader's own
};

/// How a reader is expected to show a mesh.
struct Expected {
  Eigen::Matrix3d R_told_world = Eigen::Matrix3d::Identity();
  double unit_m = 1;  ///< of the reader's numbers
  ToldColour colour = ToldColour::kSrgb;
  ToldVertices vertices = ToldVertices::kShared;
  double tolerance_m = 1e-6;  ///< floats of a metre in millimetres, and the decimals that an OBJ has
  std::optional<std::size_t> count = std::nullopt;  ///< how many vertices, where `vertices` does not say it
};

/// What is wrong with it: the counts, where it lies, each triangle with its corners and their order, each colour.
/// Empty when all is as it must be.
[[nodiscard]] std::string differences(const ToldMesh& told, const Mesh& mesh, const Expected& expected);

}  // namespace scanknit::test
