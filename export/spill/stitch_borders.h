// A surface that was cut along edges, whole again: what a GLB's primitives, or the charts of a texture, have apart.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// Parts that were appended to a mesh one after the other.
struct AppendedParts {
  std::vector<std::size_t> first_vertex;     ///< of each part, ascending; what is before the first part is left alone
  std::size_t first_triangle = 0;            ///< of the first part; each has its own vertices only
  std::vector<Eigen::Vector2f> coordinates;  ///< of a texture, one a vertex from the first part on; or none
};

/// Joins the parts where a border edge of one lies on a border edge of another that runs the other way, and both ends
/// are equal bit by bit in position, normal, colour and coordinates. Joined are edges, not points: where sheets touch
/// in a vertex, each finds its own. Two vertices of one part never become one, and neither do those of more than 32
/// parts. The order of what stays is unchanged. Normals and colours may be fewer than the positions: then they do not
/// count. O(n), and O(b log b) in the border edges. Returns the number of vertices that went.
std::size_t stitch_parts(Mesh& mesh, const AppendedParts& parts);

struct StitchedSeams {
  std::size_t vertices = 0;  ///< that went
  std::size_t guesses = 0;   ///< edges that were joined with one of several
};

/// Joins borders that lie on each other, whatever the normals and colours of their vertices: what is left of the
/// surface's topology when the seams of a texture are looked away from. A cut of no width is closed too; any other hole
/// stays open. Where rounding put several edges of seams onto one another, which belong together is a guess.
StitchedSeams stitch_seams(Mesh& mesh);

}  // namespace scanknit
