// Where to stand to see most of a mesh.
#pragma once

#include <array>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "export/picture/rasteriser.h"

namespace scanknit {

/// Front three-quarter, side or back three-quarter, from above, and the first again in clay. "Front" is the direction
/// from which most surface faces the viewer: a scan made from one side is not shown from behind, where it has none.
[[nodiscard]] std::array<View, 4> choose_views(const Mesh& mesh, UpAxis world_up);

/// Along a scanner's optical axis, upright as it held its picture unless that is upside down in the world.
[[nodiscard]] View scanner_view(const Pose& T_world_scanner, UpAxis world_up);

/// Of the vertices before the scanner, within 30 degrees of its axis and no farther than 1.5 times their median depth:
/// the foreground of its picture. The whole mesh when that is next to nothing.
[[nodiscard]] Framing framing_seen_from(const Mesh& mesh, const Pose& T_world_scanner);

}  // namespace scanknit
