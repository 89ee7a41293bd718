// Small volumes for the tests of extract/.
#pragma once

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "extract/extract_surface.h"
#include "tests/core/temporary_folder.h"
#include "tests/support/places.h"

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

/// Values -1 and 1, as of a mask.
[[nodiscard]] inline Dense binary_noise(int n, unsigned seed) {
  Dense volume = white_noise(n, seed);
  for (float& sample : volume.samples) sample = std::copysign(1.0f, sample);
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

/// Samples as a DenseView has them: (i, j, k) at i + dims.x() (j + dims.y() k). NaN: unobserved.
struct Box {
  Eigen::Vector3i dims;
  std::vector<float> samples;

  explicit Box(const Eigen::Vector3i& size, float value = 0)
      : dims(size),
        samples(static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) *
                    static_cast<std::size_t>(size.z()),
                value) {}
  /// The sample (x, y, z) becomes (i, j, k).
  explicit Box(const Dense& volume) : Box(Eigen::Vector3i::Constant(volume.n)) {
    for (int x = 0; x < volume.n; ++x) {
      for (int y = 0; y < volume.n; ++y) {
        for (int z = 0; z < volume.n; ++z) at(x, y, z) = volume.at(x, y, z);
      }
    }
  }
  [[nodiscard]] float& at(int i, int j, int k) {
    return samples[static_cast<std::size_t>(i + dims.x() * (j + dims.y() * k))];
  }
};

[[nodiscard]] inline Surface extract(const Box& box, const ExtractConfig& config = {},
                                     const Eigen::Affine3d& T_world_ijk = Eigen::Affine3d::Identity()) {
  return extract_surface(DenseView{box.samples.data(), box.dims, T_world_ijk}, config).value();
}

/// What every mesh must be, whatever the samples.
inline void expect_manifold(const MeshCheck& check) {
  EXPECT_TRUE(check.is_well_formed);
  EXPECT_EQ(check.non_manifold_edges, 0u);
  EXPECT_EQ(check.misoriented_edges, 0u);
  EXPECT_EQ(check.non_manifold_vertices, 0u);
  EXPECT_EQ(check.duplicate_triangles, 0u);
  EXPECT_EQ(check.unreferenced_vertices, 0u);
}

inline void expect_same_bits(const Mesh& mesh, const Mesh& expected) {
  EXPECT_EQ(mesh.triangles, expected.triangles);
  const auto have_same_bits = [](const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
  };
  EXPECT_TRUE(have_same_bits(mesh.positions_m, expected.positions_m));
  EXPECT_TRUE(have_same_bits(mesh.normals, expected.normals));
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

/// 10,000 cells of known Euler characteristic, at isovalue 0: L. Custodio, T. Etiene, S. Pesco, C. Silva, Practical
/// considerations on marching cubes 33 topological correctness, Computers & Graphics 2013, supplement.
[[nodiscard]] inline std::filesystem::path published_cells() {
  return data_folder() / "mc33_single_cells" / "MarchingCubes_cases.tar.xz";
}

/// Its cells are then the files in `folder`/Grids.
[[nodiscard]] inline bool unpack_published_cells(const std::filesystem::path& folder) {
  const std::string unpack = "tar -xf '" + published_cells().string() + "' -C '" + folder.string() +
                             "' --strip-components=1 --wildcards '*.iso' '*-euler_number.txt'";
  return std::system(unpack.c_str()) == 0;
}

struct PublishedCell {
  std::array<float, 8> values{};  ///< in cell.h's order of corners
  int euler = -1000;
};

/// int32 nx ny nz, float bounding box[6], float values[8], little-endian; x fastest.
[[nodiscard]] inline PublishedCell read_published_cell(const std::filesystem::path& grid) {
  constexpr std::size_t kHeaderBytes = 36;
  PublishedCell cell;
  const std::string bytes = read_text(grid);
  if (bytes.size() == kHeaderBytes + sizeof cell.values)
    std::memcpy(cell.values.data(), bytes.data() + kHeaderBytes, sizeof cell.values);
  else
    ADD_FAILURE() << grid << ": " << bytes.size() << " bytes";
  const std::string name = grid.filename().string();
  const std::string answer = name.substr(0, name.find('-')) + "-euler_number.txt";
  std::istringstream(read_text(grid.parent_path().parent_path() / "Grid_invariants" / answer)) >> cell.euler;
  return cell;
}

}  // namespace scanknit::test
