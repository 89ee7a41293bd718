// The drawings of report.html: SVG that scales to any width, its words beside it as HTML.
#pragma once

#include <string>
#include <string_view>

#include "export/report/page_text.h"

namespace scanknit {

/// How well each frame was tracked, of the report's `tracking.frames`; empty without any.
[[nodiscard]] std::string tracking_chart(const PageJson& frames);

/// The way of the camera, of a trajectory in the TUM format, from two sides, with the mesh's box where `bounds_m` is
/// one; empty when there are not two poses. `T_mesh_world`: rows of a matrix that takes the way to where the mesh was
/// put; anything else leaves it where it was.
[[nodiscard]] std::string camera_path(std::string_view trajectory, const PageJson& T_mesh_world,
                                      const PageJson& bounds_m);

/// A bar for each stage that took time, longest first.
[[nodiscard]] std::string stage_bars(const PageJson& stages);

}  // namespace scanknit
