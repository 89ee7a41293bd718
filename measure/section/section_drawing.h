// A section as a drawing in true size.
#pragma once

#include <string>

#include "measure/section/mesh_section.h"

namespace scanknit {

/// SVG in millimetres, with width, height, and the length of each of the longest outlines written on it.
[[nodiscard]] std::string section_svg(const MeshSection& section);

/// DXF of release 12 (Autodesk, "DXF Reference"), which every CAD program reads: a polyline for each outline, in
/// millimetres; holes are on a layer of their own, and lengths are texts on another.
[[nodiscard]] std::string section_dxf(const MeshSection& section);

}  // namespace scanknit
