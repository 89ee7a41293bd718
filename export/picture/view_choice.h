// Chooses the views of a mesh.
#pragma once

#include <array>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "export/picture/rasteriser.h"

namespace scanknit {

/// Front three-quarter, side or back three-quarter, from above, and the first again in grey. "Front" is the direction
/// from which most surface faces the viewer: so a scan from one side is not shown from behind, where it has no surface.
[[nodiscard]] std::array<View, 4> choose_views(const Mesh& mesh, UpAxis world_up);

/// A view along a scanner's optical axis; up is as in its picture, unless that is upside down in the world.
[[nodiscard]] View scanner_view(const Pose& T_world_scanner, UpAxis world_up);

/// The framing of the foreground of a scanner's picture: the vertices in front of it, within 30 degrees of its axis and
/// no farther than 1.5 times their median depth. The whole mesh if these are almost none.
[[nodiscard]] Framing framing_seen_from(const Mesh& mesh, const Pose& T_world_scanner);

}  // namespace scanknit
