// How fast frames enter the volume: milliseconds a frame and voxels a second, by the number of threads.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <optional>
#include <stop_token>
#include <variant>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "acquire/sensor/depth_bias.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/tsdf_volume.h"
#include "synth/synthetic_source.h"

namespace scanknit {
namespace {

constexpr int kFrames = 20;

/// The first frames of a walk round the desk scene: 640 x 480, Kinect-like noise, colour, up to 3 m.
const std::vector<Frame>& desk_frames() {
  static const std::vector<Frame> frames = [] {
    SynthConfig config;
    config.frames = 120;
    config.noise = true;
    auto scene = make_scene("desk");
    SCANKNIT_CHECK(scene.has_value());
    auto source = SyntheticSource::create(std::move(scene).value(), config);
    SCANKNIT_CHECK(source.has_value());
    std::vector<Frame> rendered;
    while (rendered.size() < kFrames) {
      FrameEvent event = source.value()->next(std::stop_token{});
      SCANKNIT_CHECK(std::holds_alternative<Frame>(event));
      rendered.push_back(std::get<Frame>(std::move(event)));
      SCANKNIT_CHECK(filter_frame(rendered.back(), AcquireConfig{}, NoiseModel{}).has_value());
    }
    return rendered;
  }();
  return frames;
}

void integrate_desk(benchmark::State& state, double truncation_sigmas) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
  const std::vector<Frame>& frames = desk_frames();
  FusionConfig config;
  config.truncation_sigmas = truncation_sigmas;
  std::int64_t blocks = 0;
  for (auto _ : state) {
    std::optional<TsdfVolume> volume(TsdfVolume::create(config).value());
    for (const Frame& frame : frames) {
      const auto stats = integrate(frame, *frame.T_world_camera, *volume);
      SCANKNIT_CHECK(stats.has_value());
      blocks += static_cast<std::int64_t>(stats->blocks_touched);
    }
    state.PauseTiming();  // giving the memory back is no part of a frame
    volume.reset();
    state.ResumeTiming();
  }
  const double done = static_cast<double>(state.iterations()) * kFrames;
  state.counters["ms/frame"] =
      benchmark::Counter(done * 1e-3, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["voxels/s"] = benchmark::Counter(static_cast<double>(blocks) * 512, benchmark::Counter::kIsRate);
  state.counters["blocks/frame"] = static_cast<double>(blocks) / done;
}

void fixed_band(benchmark::State& state) {
  integrate_desk(state, 0);
}
void band_follows_noise(benchmark::State& state) {
  integrate_desk(state, 3);
}

BENCHMARK(fixed_band)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(band_follows_noise)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void filter_desk(benchmark::State& state) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
  const Frame& first = desk_frames().front();
  for (auto _ : state) {
    Frame frame = first;
    SCANKNIT_CHECK(filter_frame(frame, AcquireConfig{}, NoiseModel{}).has_value());
    benchmark::DoNotOptimize(frame.normals);
  }
}
BENCHMARK(filter_desk)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// What acquire.camera's depth_bias adds to the reading of a frame: the correction of a picture, in place.
void correct_bias(benchmark::State& state) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
  const DepthBias bias{11, 9, std::vector<double>(99, 1e-6), std::vector<double>(99, -1e-6)};
  DepthImage depth_m = desk_frames().front().depth_m;
  const DepthCorrection correction(bias, depth_m.width(), depth_m.height());
  for (auto _ : state) {
    correction.apply(depth_m);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(correct_bias)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Once for each recording: both fields at every pixel.
void spread_bias(benchmark::State& state) {
  const DepthBias bias{11, 9, std::vector<double>(99, 1e-6), std::vector<double>(99, -1e-6)};
  for (auto _ : state) {
    const DepthCorrection correction(bias, 640, 480);
    benchmark::DoNotOptimize(&correction);
  }
}
BENCHMARK(spread_bias)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace scanknit
