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

/// Calls work(first, last) on parts of one array until all of it has been passed over.
template <typename Work>
void pass_over(benchmark::State& state, std::size_t bytes_per_float, const Work& work) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
  static std::vector<float> numbers(kFloats, 1.0f);
  for (auto _ : state) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, kFloats, 1u << 20),
                      [&](const auto& part) { work(numbers.data() + part.begin(), numbers.data() + part.end()); });
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(kFloats * bytes_per_float));
}

void read(benchmark::State& state) {
  pass_over(state, 4, [](const float* first, const float* last) {
    float sums[16] = {};
    for (; first < last; first += 16) {
      for (int i = 0; i < 16; ++i) sums[i] += first[i];
    }
    benchmark::DoNotOptimize(sums);
  });
}
/// Bytes read and bytes written are counted.
void read_modify_write(benchmark::State& state) {
  pass_over(state, 8, [](float* first, const float* last) {
    for (; first < last; ++first) *first += 1;
  });
}

BENCHMARK(read)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(read_modify_write)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
