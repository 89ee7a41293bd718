// The uncertainty of a mesh's vertices as a picture.
#pragma once

#include <optional>
#include <span>

#include "core/axes.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/pose.h"

namespace scanknit {

/// The uncertainty that has the last colour: the 95th percentile of the numbers among `uncertainty_m`, rounded up to 1,
/// 2 or 5 times a power of ten, metres; > 0.
[[nodiscard]] double uncertainty_map_end_m(std::span<const float> uncertainty_m);

/// Two views side by side, those of render_preview()'s first row, in the colours of kErrorRamp from 0 to
/// uncertainty_map_end_m(), with a scale below that says them in millimetres. `uncertainty_m`: one standard deviation a
/// vertex; NaN, which is unknown, has kUnseenColour. Deterministic.
[[nodiscard]] ColourImage draw_uncertainty_map(const Mesh& mesh, std::span<const float> uncertainty_m, UpAxis world_up,
                                               const std::optional<Pose>& T_world_scanner);

}  // namespace scanknit
