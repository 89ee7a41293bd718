// How fast volumes become meshes: cells and triangles a second, by the number of threads.
#include <benchmark/benchmark.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "extract/extract_surface.h"

namespace scanknit {
namespace {

/// A volume of n^3 active voxels.
template <typename Sample>
openvdb::FloatGrid::Ptr make_grid(int n, const Sample& sample) {
  openvdb::initialize();
  openvdb::tools::Dense<float> dense(openvdb::Coord(n), openvdb::Coord(0, 0, 0));
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) {
      for (int z = 0; z < n; ++z) dense.setValue(x, y, z, sample(x, y, z));
    }
  }
  auto grid = openvdb::FloatGrid::create(0);
  openvdb::tools::copyFromDense(dense, *grid, 0);
  for (auto leaf = grid->tree().beginLeaf(); leaf; ++leaf) leaf->setValuesOn();
  return grid;
}

void run(benchmark::State& state, const openvdb::FloatGrid& grid, std::int64_t cells) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
  FieldView view;
  view.field = &grid;
  ExtractConfig config;
  config.normals = state.range(1) != 0;
  std::int64_t triangles = 0;
  for (auto _ : state) {
    const Result<Surface> surface = extract_surface(view, config);
    triangles += static_cast<std::int64_t>(surface.value().mesh.triangles.size());
  }
  state.counters["cells"] =
      benchmark::Counter(static_cast<double>(cells * state.iterations()), benchmark::Counter::kIsRate);
  state.counters["triangles"] = benchmark::Counter(static_cast<double>(triangles), benchmark::Counter::kIsRate);
}

void sphere_256(benchmark::State& state) {
  constexpr int kSide = 256;
  const auto grid = make_grid(kSide, [](int x, int y, int z) {
    const auto centred = [](int i) { return static_cast<float>(i) - 127.4f; };
    return std::hypot(centred(x), centred(y), centred(z)) - 100.0f;
  });
  run(state, *grid, std::int64_t{kSide - 1} * (kSide - 1) * (kSide - 1));
}

void white_noise_128(benchmark::State& state) {
  constexpr int kSide = 128;
  std::mt19937 random(1);
  const auto grid =
      make_grid(kSide, [&](int, int, int) { return static_cast<float>(random()) / 2147483648.0f - 1.0f; });
  run(state, *grid, std::int64_t{kSide - 1} * (kSide - 1) * (kSide - 1));
}

const auto kThreadsAndNormals = [](benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"threads", "normals"})->ArgsProduct({{1, 2}, {0, 1}})->Unit(benchmark::kMillisecond)->UseRealTime();
};
BENCHMARK(sphere_256)->Apply(kThreadsAndNormals);
BENCHMARK(white_noise_128)->Apply(kThreadsAndNormals);

}  // namespace
}  // namespace scanknit
