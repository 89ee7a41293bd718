// What tracking costs a frame, part by part, by the number of threads: 640 x 480 with colour, at half resolution.
#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <stop_token>
#include <variant>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/register/icp.h"
#include "fusion/register/picture_shift.h"
#include "fusion/register/surface_pyramid.h"
#include "fusion/track/raycast.h"
#include "synth/synthetic_source.h"

namespace scanknit {
namespace {

/// The desk scene after five frames, its view from the fifth, and the sixth: 3 degrees and 5 cm further.
struct Desk {
  TsdfVolume volume;
  Frame frame;
  Pose T_world_before;
  ModelView view;
  SurfacePyramid seen, model;
};

const Desk& desk() {
  static const Desk desk = [] {
    SynthConfig config;
    config.frames = 120;
    config.noise = true;
    auto scene = make_scene("desk");
    SCANKNIT_CHECK(scene.has_value());
    auto source = SyntheticSource::create(std::move(scene).value(), config);
    SCANKNIT_CHECK(source.has_value());
    auto volume = TsdfVolume::create(FusionConfig{});
    SCANKNIT_CHECK(volume.has_value());
    Desk made{std::move(volume).value(), {}, Pose::Identity(), {}, {}, {}};
    for (int i = 0; i < 6; ++i) {
      if (i > 0) {
        made.T_world_before = *made.frame.T_world_camera;
        SCANKNIT_CHECK(integrate(made.frame, made.T_world_before, made.volume).has_value());
      }
      FrameEvent event = source.value()->next(std::stop_token{});
      SCANKNIT_CHECK(std::holds_alternative<Frame>(event));
      made.frame = std::get<Frame>(std::move(event));
      SCANKNIT_CHECK(filter_frame(made.frame, AcquireConfig{}, NoiseModel{}).has_value());
    }
    made.view = raycast(made.volume, tracking_camera(made.frame.intrinsics), made.T_world_before);
    made.seen = pyramid_of(made.frame, NoiseModel{});
    made.model = pyramid_of(made.view, NoiseModel{});
    return made;
  }();
  return desk;
}

template <typename Work>
void measure(benchmark::State& state, Work work) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(state.range(0)));
  const Desk& scene = desk();
  for (auto _ : state) benchmark::DoNotOptimize(work(scene));
}

void look_at_volume(benchmark::State& state) {
  measure(state, [](const Desk& d) { return raycast(d.volume, d.view.intrinsics, d.T_world_before); });
}
void frame_pyramid(benchmark::State& state) {
  measure(state, [](const Desk& d) { return pyramid_of(d.frame, NoiseModel{}); });
}
void model_pyramid(benchmark::State& state) {
  measure(state, [](const Desk& d) { return pyramid_of(d.view, NoiseModel{}); });
}
void picture_shift(benchmark::State& state) {
  measure(state, [](const Desk& d) { return turn_by_shift(d.seen, d.model); });
}
void registration(benchmark::State& state) {
  measure(state, [](const Desk& d) { return register_frame(d.seen, d.model, Pose::Identity(), {NoiseModel{}}); });
}

BENCHMARK(look_at_volume)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(frame_pyramid)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(model_pyramid)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(picture_shift)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(registration)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace scanknit
