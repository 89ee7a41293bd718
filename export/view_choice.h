// Where to stand to see most of a mesh.
#pragma once

#include <array>

#include "core/axes.h"
#include "core/mesh.h"
#include "export/rasteriser.h"

namespace scanknit {

/// Front three-quarter, side or back three-quarter, from above, and the first again in clay. "Front" is the direction
/// from which most surface faces the viewer: a scan made from one side is not shown from behind, where it has none.
[[nodiscard]] std::array<View, 4> choose_views(const Mesh& mesh, UpAxis world_up);

}  // namespace scanknit
