// What it costs to follow a volume that changes: a full extraction against updates of a part of the leaves.
#include <benchmark/benchmark.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "extract/extract_surface.h"
#include "extract/incremental_mesher.h"

namespace scanknit {
namespace {

constexpr int kSide = 256;

/// As a scan's: a noisy sphere's truncated distances, in the leaves that its band of 8 voxels to both sides meets.
openvdb::FloatGrid::Ptr make_band() {
  openvdb::initialize();
  constexpr float kTruncation = 8;
  std::mt19937 random(1);
  auto grid = openvdb::FloatGrid::create(kTruncation);
  const openvdb::Vec3d centre(127.4);
  for (int i = 0; i < kSide / 8 * (kSide / 8) * (kSide / 8); ++i) {
    const openvdb::Coord origin(i / 1024 * 8, i / 32 % 32 * 8, i % 32 * 8);
    const double from_surface = (origin.asVec3d() + openvdb::Vec3d(3.5) - centre).length() - 100;
    constexpr double kHalfDiagonal = 6.1;
    if (std::abs(from_surface) > double{kTruncation} + kHalfDiagonal) continue;
    auto* const leaf = grid->tree().touchLeaf(origin);
    for (openvdb::Index voxel = 0; voxel < leaf->SIZE; ++voxel) {
      const double distance = (leaf->offsetToGlobalCoord(voxel).asVec3d() - centre).length() - 100;
      const float noise = static_cast<float>(random()) / 2147483648.0f - 1.0f;
      leaf->setValueOn(voxel, std::clamp(static_cast<float>(distance) + noise, -kTruncation, kTruncation));
    }
  }
  return grid;
}

std::vector<Eigen::Vector3i> leaf_origins(const openvdb::FloatGrid& grid) {
  std::vector<Eigen::Vector3i> origins;
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    origins.emplace_back(leaf->origin().x(), leaf->origin().y(), leaf->origin().z());
  return origins;
}

/// The band and all that a run needs of it; made once.
struct Band {
  openvdb::FloatGrid::Ptr grid = make_band();
  std::vector<Eigen::Vector3i> leaves = leaf_origins(*grid);
};
Band& band() {
  static Band the_band;
  return the_band;
}

ExtractConfig config_of(const benchmark::State& state) {
  ExtractConfig config;
  config.normals = state.range(0) != 0;
  return config;
}

FieldView view_of(const openvdb::FloatGrid& grid) {
  FieldView view;
  view.field = &grid;
  return view;
}

/// Moves the surface a little in some leaves.
void change(openvdb::FloatGrid& grid, std::span<const Eigen::Vector3i> leaves, float by) {
  for (const Eigen::Vector3i& origin : leaves) {
    auto* const leaf = grid.tree().probeLeaf({origin.x(), origin.y(), origin.z()});
    for (float& value : std::span(leaf->buffer().data(), leaf->SIZE)) value += by;
  }
}

void full_extraction(benchmark::State& state) {
  const ExtractConfig config = config_of(state);
  for (auto _ : state)
    benchmark::DoNotOptimize(extract_surface(view_of(*band().grid), config).value().mesh.triangles.data());
  state.counters["leaves"] = static_cast<double>(band().leaves.size());
}

/// `leaves`: in the order in which they change.
void run_updates(benchmark::State& state, std::vector<Eigen::Vector3i> leaves) {
  const std::size_t count = leaves.size() * static_cast<std::size_t>(state.range(1)) / 100;
  auto mesher = IncrementalMesher::create(view_of(*band().grid), config_of(state)).value();
  benchmark::DoNotOptimize(mesher.update(leaves).value().size());
  const auto changed = std::span(leaves).first(count);
  float by = 0.01f;
  std::size_t different = 0;
  for (auto _ : state) {
    state.PauseTiming();
    change(*band().grid, changed, by);
    by = -by;
    state.ResumeTiming();
    different = mesher.update(changed).value().size();
  }
  if (by < 0) change(*band().grid, changed, by);
  state.counters["changed"] = static_cast<double>(count);
  state.counters["patches"] = static_cast<double>(different);
}

/// What a depth frame sees: the leaves nearest to one place.
void update_of_a_region(benchmark::State& state) {
  std::vector<Eigen::Vector3i> leaves = band().leaves;
  const Eigen::Vector3i place(224, 128, 128);
  std::stable_sort(leaves.begin(), leaves.end(), [&](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return (a - place).squaredNorm() < (b - place).squaredNorm();
  });
  run_updates(state, std::move(leaves));
}

/// The worst case: no two changed leaves share their neighbours.
void update_here_and_there(benchmark::State& state) {
  std::vector<Eigen::Vector3i> leaves = band().leaves;
  std::shuffle(leaves.begin(), leaves.end(), std::mt19937(1));
  run_updates(state, std::move(leaves));
}

BENCHMARK(full_extraction)->ArgNames({"normals"})->DenseRange(0, 1)->Unit(benchmark::kMillisecond)->UseRealTime();
const auto kNormalsAndPercent = [](benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"normals", "percent"})
      ->ArgsProduct({{0, 1}, {0, 1, 10, 100}})
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
};
BENCHMARK(update_of_a_region)->Apply(kNormalsAndPercent);
BENCHMARK(update_here_and_there)->Apply(kNormalsAndPercent);

}  // namespace
}  // namespace scanknit
