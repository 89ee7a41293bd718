// Small volumes for the tests of extract/.
#pragma once

#include <openvdb/openvdb.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "extract/extract_surface.h"

namespace scanknit::test {

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// n^3 samples, index (x n + y) n + z; NaN: unobserved.
struct Dense {
  int n = 0;
  std::vector<float> samples;

  explicit Dense(int side, float value = 0) : n(side), samples(static_cast<std::size_t>(side * side * side), value) {}
  [[nodiscard]] float& at(int x, int y, int z) { return samples[static_cast<std::size_t>((x * n + y) * n + z)]; }
  [[nodiscard]] float at(int x, int y, int z) const { return samples[static_cast<std::size_t>((x * n + y) * n + z)]; }
};

[[nodiscard]] inline Dense dense_from(int n, const std::function<double(double, double, double)>& f) {
  Dense volume(n);
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) volume.at(x, y, z) = static_cast<float>(f(x, y, z));
    }
  }
  return volume;
}

[[nodiscard]] inline Dense white_noise(int n, unsigned seed) {
  std::mt19937 random(seed);
  Dense volume(n);
  for (float& sample : volume.samples) sample = static_cast<float>(random()) / 2147483648.0f - 1.0f;
  return volume;
}

/// Values -1, 0 and 1: a third of the samples lie on isovalue 0, and most face saddles tie.
[[nodiscard]] inline Dense three_level_noise(int n, unsigned seed) {
  std::mt19937 random(seed);
  Dense volume(n);
  for (float& sample : volume.samples) sample = static_cast<float>(random() % 3) - 1.0f;
  return volume;
}

/// Makes one sample in `one_in` NaN.
inline void punch_holes(Dense& volume, unsigned one_in, unsigned seed) {
  std::mt19937 random(seed);
  for (float& sample : volume.samples) {
    if (random() % one_in == 0) sample = kNaN;
  }
}

struct GridPlace {
  openvdb::Coord first{0, 0, 0};
  double voxel_size_m = 1;
  openvdb::Vec3d translation_m{0, 0, 0};
};

/// Every sample is active, NaN or not.
[[nodiscard]] inline openvdb::FloatGrid::Ptr make_grid(const Dense& volume, const GridPlace& place = {}) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(place.voxel_size_m));
  grid->transform().postTranslate(place.translation_m);
  auto accessor = grid->getAccessor();
  for (int x = 0; x < volume.n; ++x) {
    for (int y = 0; y < volume.n; ++y) {
      for (int z = 0; z < volume.n; ++z) accessor.setValueOn(place.first.offsetBy(x, y, z), volume.at(x, y, z));
    }
  }
  return grid;
}

[[nodiscard]] inline FieldView view_of(const openvdb::FloatGrid& grid) {
  FieldView view;
  view.field = &grid;
  return view;
}

[[nodiscard]] inline Surface extract(const Dense& volume, const ExtractConfig& config = {},
                                     const GridPlace& place = {}) {
  const auto grid = make_grid(volume, place);
  return extract_surface(view_of(*grid), config).value();
}

/// The edges of the isosurface that bound it: where it meets a grid face that has a whole (observed) cell on one side
/// only. Counted from the samples alone, without a table: half the crossed edges of each such face.
[[nodiscard]] inline std::size_t expected_boundary_edges(const Dense& volume, float isovalue) {
  const auto observed = [&](const openvdb::Coord& p) {
    return p.asVec3i().sorted()[0] >= 0 && p.asVec3i().sorted()[2] < volume.n &&
           std::isfinite(volume.at(p.x(), p.y(), p.z()));
  };
  const auto is_whole = [&](const openvdb::Coord& cell) {
    for (int i = 0; i < 8; ++i) {
      if (!observed(cell.offsetBy(i & 1, (i >> 1) & 1, i >> 2))) return false;
    }
    return true;
  };
  std::size_t crossed = 0;
  const auto add_face = [&](const openvdb::Coord& p, int axis) {
    openvdb::Coord behind = p;
    behind[axis] -= 1;
    if (is_whole(p) == is_whole(behind)) return;
    openvdb::Coord u(0, 0, 0);
    openvdb::Coord v(0, 0, 0);
    u[(axis + 1) % 3] = 1;
    v[(axis + 2) % 3] = 1;
    const auto high = [&](const openvdb::Coord& q) { return volume.at(q.x(), q.y(), q.z()) >= isovalue; };
    const bool ring[4] = {high(p), high(p + u), high(p + u + v), high(p + v)};
    for (int i = 0; i < 4; ++i) crossed += ring[i] != ring[(i + 1) % 4] ? 1 : 0;
  };
  for (int x = 0; x < volume.n; ++x) {
    for (int y = 0; y < volume.n; ++y) {
      for (int z = 0; z < volume.n; ++z) {
        for (int axis = 0; axis < 3; ++axis) add_face({x, y, z}, axis);
      }
    }
  }
  return crossed / 2;
}

}  // namespace scanknit::test
