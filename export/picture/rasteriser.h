// A small software rasteriser: one mesh, one view, no display or GPU.
#pragma once

#include <Eigen/Core>
#include <span>

#include "core/image.h"
#include "core/mesh.h"

namespace scanknit {

inline constexpr Rgb8 kBackground{245, 245, 245};
inline constexpr Rgb8 kClay{190, 190, 190};

/// A perspective camera that looks along `forward` at the mesh and stands just far enough away to see all of its
/// framing.
struct View {
  Eigen::Vector3d forward{0, 0, 1};    ///< unit
  Eigen::Vector3d up{0, -1, 0};        ///< unit, not parallel to `forward`; upright in the picture
  bool in_colour = true;               ///< false, or a mesh without colours: grey clay
  std::span<const Rgb8> colours = {};  ///< of the vertices, instead of the mesh's; empty: the mesh's
};

/// Where the mesh is: its bounding box, or the box between the first and the 99th percentile of each coordinate where
/// a few stray triangles make the bounding box half as large again.
struct Framing {
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d max_m = Eigen::Vector3d::Zero();
};
[[nodiscard]] Framing framing(const Mesh& mesh);

/// The mesh must satisfy Mesh's promises. Triangles seen from behind are left out, so that one looks into a room from
/// outside as into a doll's house. Shaded by a lamp at the camera; anti-aliased by 2 x 2 samples a pixel. An empty mesh
/// gives an empty background. Deterministic; runs in one thread.
[[nodiscard]] ColourImage render_view(const Mesh& mesh, const Framing& frame, const View& view, int width, int height);

}  // namespace scanknit
