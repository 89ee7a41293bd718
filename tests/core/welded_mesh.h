// Meshes whose vertices were doubled, as one surface again.
#pragma once

#include <array>
#include <map>

#include "core/mesh.h"

namespace scanknit::test {

/// One vertex for all at the same place; the triangles in their order.
inline Mesh welded(const Mesh& mesh) {
  Mesh made;
  std::map<std::array<float, 3>, std::uint32_t> number;
  const auto vertex = [&](std::uint32_t v) {
    const Eigen::Vector3f& p = mesh.positions_m.at(v);
    const auto [found, is_new] =
        number.try_emplace({p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(made.positions_m.size()));
    if (is_new) made.positions_m.push_back(p);
    return found->second;
  };
  for (const Triangle& t : mesh.triangles) {
    Triangle& corners = made.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) corners[k] = vertex(t[k]);
  }
  return made;
}

}  // namespace scanknit::test
