// What the machine's memory gives: the floor under everything that fusion does.
#include <benchmark/benchmark.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

constexpr std::size_t kFloats = 192u << 20;  // 768 MiB: far beyond every cache

/// Bytes read and bytes written are counted.
void read_modify_write(benchmark::State& state) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
  std::vector<float> numbers(kFloats, 1.0f);
  for (auto _ : state) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, kFloats, 1u << 20), [&](const auto& part) {
      for (std::size_t i = part.begin(); i < part.end(); ++i) numbers[i] += 1;
    });
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(2 * kFloats * sizeof(float)));
}

BENCHMARK(read_modify_write)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
