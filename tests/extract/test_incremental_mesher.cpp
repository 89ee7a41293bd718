// A live surface against the full extraction.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "extract/incremental_mesher.h"
#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using openvdb::Coord;

/// Three grids as in TsdfVolume, whose leaves change at random; the leaves lie in [-16, 16)^3.
class LiveVolume {
 public:
  /// `levels` 0: smooth and noisy values; else the integers round 0, that many, so that ties abound.
  explicit LiveVolume(unsigned seed, unsigned levels = 0) : random_(seed), levels_(levels) {
    openvdb::initialize();
    field = openvdb::FloatGrid::create(1);
    weight = openvdb::FloatGrid::create(0);
    colour = openvdb::Vec3SGrid::create(openvdb::Vec3s(-1));
  }

  void place(const openvdb::math::Mat4d& world_from_index) {
    const auto transform = openvdb::math::Transform::createLinearTransform(world_from_index);
    for (openvdb::GridBase* grid : {static_cast<openvdb::GridBase*>(&*field), static_cast<openvdb::GridBase*>(&*weight),
                                    static_cast<openvdb::GridBase*>(&*colour)}) {
      grid->setTransform(transform->copy());
    }
  }

  /// Adds, changes and removes a few leaves, and returns their origins.
  std::vector<Eigen::Vector3i> change(int leaves) {
    std::vector<Eigen::Vector3i> changed;
    for (int i = 0; i < leaves; ++i) {
      const auto place = [this] { return kBlockCells * (static_cast<int>(below(4)) - 2); };
      const Eigen::Vector3i origin(place(), place(), place());
      const Coord at(origin.x(), origin.y(), origin.z());
      const unsigned kind = below(8);
      if (field->tree().probeConstLeaf(at) == nullptr || kind == 0) {
        add(at);
      } else if (kind == 1) {
        remove(at);
      } else {
        disturb(at, kind);
      }
      changed.push_back(origin);
    }
    return changed;
  }

  void add(const Coord& at) {
    for (unsigned i = 0; i < 512; ++i) set(at + voxel(i), sample(at + voxel(i)), below(40) == 0 ? 0.0f : 2.0f);
  }

  void remove(const Coord& at) {
    constexpr openvdb::Index kInPlaceOfALeaf = 1;
    field->tree().addTile(kInPlaceOfALeaf, at, 1.0f, false);
    weight->tree().addTile(kInPlaceOfALeaf, at, 0.0f, false);
    colour->tree().addTile(kInPlaceOfALeaf, at, openvdb::Vec3s(-1), false);
  }

  std::shared_ptr<openvdb::FloatGrid> field;
  std::shared_ptr<openvdb::FloatGrid> weight;
  std::shared_ptr<openvdb::Vec3SGrid> colour;

 private:
  [[nodiscard]] static Coord voxel(unsigned i) {
    return {static_cast<int>(i >> 6), static_cast<int>((i >> 3) & 7), static_cast<int>(i & 7)};
  }
  [[nodiscard]] unsigned below(unsigned n) { return static_cast<unsigned>(random_() % n); }
  [[nodiscard]] float noise() { return static_cast<float>(random_()) / 2147483648.0f - 1.0f; }
  [[nodiscard]] float sample(const Coord& p) {
    if (levels_ > 0) return static_cast<float>(below(levels_)) - static_cast<float>(levels_ / 2);
    return std::clamp(0.15f * (static_cast<float>(p.asVec3d().length()) - 10) + noise(), -1.0f, 1.0f);
  }

  /// One voxel, a corner of the leaf, a few, or all.
  void disturb(const Coord& at, unsigned kind) {
    if (kind == 2) return set(at + voxel(below(512)), sample(at), 2);
    if (kind == 3) return set(at + voxel(below(2) * 448 + below(2) * 56 + below(2) * 7), noise(), 0);
    const unsigned step = kind == 4 ? 1 : 37;
    for (unsigned i = below(step); i < 512; i += step)
      set(at + voxel(i), sample(at + voxel(i)), static_cast<float>(below(4)));
  }

  void set(const Coord& p, float value, float new_weight) {
    auto values = field->getAccessor();
    values.setValueOnly(p, value);
    values.setActiveState(p, new_weight > 0);
    auto weights = weight->getAccessor();
    weights.setValueOnly(p, new_weight);
    weights.setActiveState(p, new_weight > 0);
    const bool has_seen_colour = below(8) != 0;
    const auto channel = [this] { return 0.5f * noise() + 0.5f; };
    colour->getAccessor().setValueOn(
        p, has_seen_colour ? openvdb::Vec3s(channel(), channel(), channel()) : openvdb::Vec3s(-1));
  }

  std::mt19937 random_;
  unsigned levels_;
};

FieldView view_of(const LiveVolume& volume, bool with_weight = true, bool with_colour = true) {
  FieldView view;
  view.field = &*volume.field;
  if (with_weight) view.weight = &*volume.weight;
  if (with_colour) view.colour = &*volume.colour;
  return view;
}

/// The bits of a vertex: position, normal, colour.
using Corner = std::array<std::uint32_t, 7>;
using Corners = std::array<Corner, 3>;

/// All triangles by their corners, each from its least corner on in its own orientation, in order.
std::vector<Corners> triangles_of(const Mesh& mesh) {
  const auto corner = [&](std::uint32_t v) {
    Corner bits{};
    for (int i = 0; i < 3; ++i) {
      const auto place = static_cast<std::size_t>(i);
      bits[place] = std::bit_cast<std::uint32_t>(mesh.positions_m[v][i]);
      if (!mesh.normals.empty()) bits[place + 3] = std::bit_cast<std::uint32_t>(mesh.normals[v][i]);
    }
    if (!mesh.colours.empty()) {
      const Rgb8& c = mesh.colours[v];
      bits[6] = std::uint32_t{c.r} | std::uint32_t{c.g} << 8 | std::uint32_t{c.b} << 16;
    }
    return bits;
  };
  std::vector<Corners> triangles;
  for (const Triangle& t : mesh.triangles) {
    Corners corners{corner(t[0]), corner(t[1]), corner(t[2])};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::vector<Eigen::Vector3i> updated(IncrementalMesher& mesher, std::span<const Eigen::Vector3i> changed) {
  auto origins = mesher.update(changed);
  EXPECT_TRUE(origins) << (origins ? "" : origins.error().text());
  return origins ? std::move(*origins) : std::vector<Eigen::Vector3i>{};
}

constexpr int kRounds = 20;

/// Changes the volume round by round, and expects the patches to be the full extraction every time.
void expect_full_surface(LiveVolume& volume, const FieldView& view, const ExtractConfig& config) {
  auto mesher = IncrementalMesher::create(view, config).value();
  std::size_t most_triangles = 0;
  for (int round = 0; round < kRounds; ++round) {
    updated(mesher, volume.change(round == 0 ? 60 : 3));
    const Mesh full = extract_surface(view, config).value().mesh;
    const Mesh patches = mesher.mesh().value();
    ASSERT_EQ(patches.normals.size(), config.normals ? patches.positions_m.size() : 0);
    ASSERT_EQ(patches.colours.size(), view.colour != nullptr ? patches.positions_m.size() : 0);
    ASSERT_TRUE(triangles_of(patches) == triangles_of(full)) << "round " << round;
    most_triangles = std::max(most_triangles, full.triangles.size());
  }
  EXPECT_GT(most_triangles, 1000u);
}

TEST(IncrementalMesher, PatchesAreTheFullSurface) {
  LiveVolume volume(1);
  expect_full_surface(volume, view_of(volume), {});
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceWithoutWeightsAndColours) {
  LiveVolume volume(2);
  expect_full_surface(volume, view_of(volume, false, false), {});
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceWhereOnlyPositionsAreWanted) {
  LiveVolume volume(3);
  ExtractConfig config;
  config.normals = false;
  expect_full_surface(volume, view_of(volume, true, false), config);
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceForColoursWithoutNormals) {
  LiveVolume volume(4);
  ExtractConfig config;
  config.normals = false;
  expect_full_surface(volume, view_of(volume), config);
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceAtAnIsovalueAndAWeight) {
  LiveVolume volume(5);
  ExtractConfig config;
  config.isovalue = 0.125;
  config.min_weight = 2;
  config.inside = InsideSide::kHigh;
  config.placement = VertexPlacement::kMidEdge;
  expect_full_surface(volume, view_of(volume), config);
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceWhereSamplesLieOnTheIsovalue) {
  LiveVolume volume(6, 3);
  ExtractConfig config;
  config.normals = false;  // the gradient is zero here and there
  expect_full_surface(volume, view_of(volume), config);
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceForEveryDecider) {
  unsigned seed = 7;
  for (const Decider decider :
       {Decider::kAsymptotic, Decider::kChord, Decider::kFixedHigh, Decider::kFixedLow, Decider::kLorensen}) {
    LiveVolume volume(seed++);
    ExtractConfig config;
    config.decider = decider;
    expect_full_surface(volume, view_of(volume), config);
  }
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceForKnitWhichLooksIntoNeighbouringCells) {
  for (const bool with_weight : {true, false}) {
    LiveVolume volume(20 + (with_weight ? 1 : 0));
    ExtractConfig config;
    config.decider = Decider::kKnit;
    config.normals = false;  // so that nothing but the decider makes neighbours depend on each other
    expect_full_surface(volume, view_of(volume, with_weight, false), config);
  }
}

TEST(IncrementalMesher, PatchesAreTheFullSurfaceInAMirroredVolumeFarAway) {
  LiveVolume volume(30);
  auto world_from_index = openvdb::math::Mat4d::identity();
  world_from_index.postScale(openvdb::Vec3d(0.001, -0.002, 0.003));
  world_from_index.setTranslation(openvdb::Vec3d(900, -700, 500));
  volume.place(world_from_index);
  expect_full_surface(volume, view_of(volume), {});
}

TEST(IncrementalMesher, MeshesChangedLeavesAndNeighboursOnly) {
  LiveVolume volume(40);
  const FieldView view = view_of(volume);
  auto mesher = IncrementalMesher::create(view, {}).value();
  updated(mesher, volume.change(60));
  for (int round = 0; round < kRounds; ++round) {
    const auto changed = volume.change(1);
    const auto different = updated(mesher, changed);
    EXPECT_LE(different.size(), 27u);
    for (const Eigen::Vector3i& origin : different) EXPECT_LE((origin - changed[0]).cwiseAbs().maxCoeff(), kBlockCells);
  }
}

TEST(IncrementalMesher, MeshesLowerNeighboursOnlyWhereOnlyPositionsAreWanted) {
  LiveVolume volume(41);
  ExtractConfig config;
  config.normals = false;
  auto mesher = IncrementalMesher::create(view_of(volume, true, false), config).value();
  updated(mesher, volume.change(60));
  for (int round = 0; round < kRounds; ++round) {
    const auto changed = volume.change(1);
    for (const Eigen::Vector3i& origin : updated(mesher, changed)) {
      EXPECT_LE((origin - changed[0]).maxCoeff(), 0);
      EXPECT_GE((origin - changed[0]).minCoeff(), -kBlockCells);
    }
  }
}

TEST(IncrementalMesher, OtherPatchesKeepPlaceAndRevision) {
  LiveVolume volume(42);
  auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
  updated(mesher, volume.change(60));
  std::size_t kept = 0;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<std::pair<const MeshPatch*, MeshPatch>> before;
    for (const auto& [origin, patch] : mesher.patches()) before.emplace_back(&patch, patch);
    const auto different = updated(mesher, volume.change(1));
    for (const auto& [address, patch] : before) {
      if (std::binary_search(different.begin(), different.end(), patch.origin, is_before)) continue;
      const auto found = mesher.patches().find(patch.origin);
      ASSERT_NE(found, mesher.patches().end());
      EXPECT_EQ(&found->second, address);
      EXPECT_EQ(address->revision, patch.revision);
      EXPECT_EQ(address->mesh.positions_m, patch.mesh.positions_m);
      EXPECT_EQ(address->mesh.triangles, patch.mesh.triangles);
      ++kept;
    }
  }
  EXPECT_GT(kept, 100u);
}

TEST(IncrementalMesher, DifferentPatchesHaveTheNewRevisionAndAllOthersAnOlderOne) {
  LiveVolume volume(43);
  auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t before = mesher.revision();
    const auto different = updated(mesher, volume.change(round == 0 ? 60 : 1));
    EXPECT_EQ(mesher.revision(), before + (different.empty() ? 0 : 1));
    for (const auto& [origin, patch] : mesher.patches()) {
      const bool is_different = std::binary_search(different.begin(), different.end(), origin, is_before);
      EXPECT_EQ(patch.revision > before, is_different);
      EXPECT_LE(patch.revision, mesher.revision());
      EXPECT_EQ(patch.origin, origin);
      EXPECT_FALSE(patch.mesh.empty());
    }
  }
}

TEST(IncrementalMesher, NothingChangedDoesNothing) {
  LiveVolume volume(44);
  auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
  const auto leaves = volume.change(30);
  EXPECT_FALSE(updated(mesher, leaves).empty());
  EXPECT_TRUE(updated(mesher, {}).empty());
  EXPECT_TRUE(updated(mesher, leaves).empty());  // said to be changed, but they are not
  EXPECT_EQ(mesher.revision(), 1u);
}

TEST(IncrementalMesher, EmptyVolumeHasNoPatches) {
  LiveVolume volume(45);
  auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
  EXPECT_TRUE(updated(mesher, std::vector{Eigen::Vector3i(8, 0, -8)}).empty());
  EXPECT_TRUE(mesher.patches().empty());
  EXPECT_TRUE(mesher.mesh().value().empty());
}

TEST(IncrementalMesher, PatchesGoWhenAllLeavesGo) {
  LiveVolume volume(46);
  auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
  auto leaves = volume.change(30);
  updated(mesher, leaves);
  const std::size_t patches = mesher.patches().size();
  for (const Eigen::Vector3i& origin : leaves) volume.remove({origin.x(), origin.y(), origin.z()});
  EXPECT_EQ(updated(mesher, leaves).size(), patches);
  EXPECT_TRUE(mesher.patches().empty());
}

TEST(IncrementalMesher, EveryPatchIsManifold) {
  LiveVolume volume(47);
  auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
  for (int round = 0; round < kRounds; ++round) updated(mesher, volume.change(10));  // holes that pinch the surface
  for (const auto& [origin, patch] : mesher.patches()) {
    const MeshCheck check = check_mesh(patch.mesh);
    EXPECT_TRUE(check.is_well_formed);
    EXPECT_TRUE(check.is_manifold());
    EXPECT_EQ(check.unreferenced_vertices, 0u);
  }
}

TEST(IncrementalMesher, SamePatchesForAnyNumberOfThreadsAndWhateverChangedTogether) {
  std::vector<MeshPatches> patches;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    LiveVolume volume(48);
    auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
    std::vector<Eigen::Vector3i> all;
    for (int round = 0; round < 4; ++round) {
      const auto changed = volume.change(30);
      all.insert(all.end(), changed.begin(), changed.end());
      if (threads != 2) updated(mesher, changed);  // else all at once
    }
    if (threads == 2) updated(mesher, all);
    patches.push_back(mesher.patches());
  }
  for (const MeshPatches& other : patches) {
    ASSERT_EQ(other.size(), patches[0].size());
    for (const auto& [origin, patch] : patches[0]) {
      const auto found = other.find(origin);
      ASSERT_NE(found, other.end());
      EXPECT_EQ(found->second.mesh.positions_m, patch.mesh.positions_m);
      EXPECT_EQ(found->second.mesh.normals, patch.mesh.normals);
      EXPECT_EQ(found->second.mesh.colours, patch.mesh.colours);
      EXPECT_EQ(found->second.mesh.triangles, patch.mesh.triangles);
    }
  }
}

TEST(IncrementalMesher, RefusesTetrahedra) {
  LiveVolume volume(49);
  ExtractConfig config;
  for (const Decider decider : {Decider::kTetra5, Decider::kTetra6, Decider::kTetra24}) {
    config.decider = decider;
    const auto mesher = IncrementalMesher::create(view_of(volume), config);
    ASSERT_FALSE(mesher);
    EXPECT_EQ(mesher.error().code, ErrorCode::kConfig);
  }
}

TEST(IncrementalMesher, RefusesActiveTilesAndKeepsItsPatches) {
  LiveVolume volume(50);
  const FieldView view = view_of(volume);
  auto mesher = IncrementalMesher::create(view, {}).value();
  updated(mesher, volume.change(30));
  const auto before = triangles_of(mesher.mesh().value());
  volume.field->tree().addTile(1, Coord(16, 0, 0), 1.0f, true);
  const auto result = mesher.update(std::vector{Eigen::Vector3i(0, 0, 0), Eigen::Vector3i(16, 0, 0)});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kConfig);
  EXPECT_TRUE(triangles_of(mesher.mesh().value()) == before);
  EXPECT_EQ(mesher.revision(), 1u);
  EXPECT_FALSE(IncrementalMesher::create(view, {}));
}

TEST(IncrementalMesher, RefusesLeavesAtTheEndOfTheCoordinates) {
  LiveVolume volume(51);
  auto mesher = IncrementalMesher::create(view_of(volume), {}).value();
  constexpr int kLast = std::numeric_limits<int>::max() - 7;
  for (const Eigen::Vector3i& origin : {Eigen::Vector3i(kLast, 0, 0), Eigen::Vector3i(0, 0, -kLast - 8)}) {
    const auto result = mesher.update(std::span(&origin, 1));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::kConfig);
  }
}

}  // namespace
}  // namespace scanknit
