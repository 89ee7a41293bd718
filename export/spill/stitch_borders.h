// Joins a surface that was cut along edges: the primitives of a GLB, or the charts of a texture.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// The parts that were appended to a mesh, in order.
struct AppendedParts {
  std::vector<std::size_t> first_vertex;     ///< of each part, ascending; vertices before the first part do not change
  std::size_t first_triangle = 0;            ///< of the first part; each part uses only its own vertices
  std::vector<Eigen::Vector2f> coordinates;  ///< texture coordinates of each vertex from the first part on; or none
};

/// Joins parts at border edges with opposite directions whose ends are bit-equal in position, normal, colour and
/// coordinates. It joins edges, not points: where sheets touch at a vertex, each keeps its own. Never joins two
/// vertices of one part, or those of more than 32 parts. The order of the rest is unchanged. Ignores normals and
/// colours if there are fewer of them than positions. O(n), and O(b log b) in the border edges. Returns the number of
/// removed vertices.
std::size_t stitch_parts(Mesh& mesh, const AppendedParts& parts);

struct StitchedSeams {
  std::size_t vertices = 0;  ///< vertices removed
  std::size_t guesses = 0;   ///< edges joined with one of several candidates
};

/// Joins coincident borders, whatever the normals and colours of their vertices: this gives the surface's topology
/// without the seams of a texture. It also closes cuts of zero width; all other holes stay open. If rounding made
/// several seam edges coincide, it guesses which of them belong together.
StitchedSeams stitch_seams(Mesh& mesh);

}  // namespace scanknit
