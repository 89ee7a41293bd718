// Range scans: from the grid to the volume, and from anywhere to their place.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "fusion/align/align_scans.h"
#include "fusion/range/range_integrate.h"
#include "synth/render.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/scene.h"

namespace scanknit {
namespace {

constexpr CameraIntrinsics kCamera{320, 240, 380, 380, 159.5, 119.5};

/// The figurine from one side: 320 x 240 lines of sight, a quarter of which meet it.
RangeScan scan_from(double degrees) {
  const auto scene = make_scene("turntable");
  const double angle = degrees * std::numbers::pi / 180;
  const Pose T_world_camera = look_at({0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.2}, Eigen::Vector3d::Zero());
  const RenderedView view = render(**scene, kCamera, T_world_camera);
  RangeScan scan;
  scan.points_m = Image<Eigen::Vector3f>(kCamera.width, kCamera.height, kNoReturn);
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) {
      const float z = view.depth_m.at(x, y);
      if (z > 0) scan.points_m.at(x, y) = kCamera.unproject(x, y, z).cast<float>();
    }
  }
  scan.sight = {.kind = SightLines::Kind::kSphere, .pole = 1};
  return scan;
}

void FuseRangeScan(benchmark::State& state) {
  const RangeScan scan = scan_from(0);
  FusionConfig config;
  config.voxel_size_m = 0.001;
  for ([[maybe_unused]] auto _ : state) {
    auto volume = TsdfVolume::create(config);
    const RangeSurface surface = find_surface(scan);
    benchmark::DoNotOptimize(integrate(RangeView(scan, surface), surface.noise_m, Pose::Identity(), *volume));
  }
}
BENCHMARK(FuseRangeScan)->Unit(benchmark::kMillisecond)->UseRealTime();

void AlignScans(benchmark::State& state) {
  std::vector<ScanModel> models;
  for (int i = 0; i < state.range(0); ++i) {
    const RangeScan scan = scan_from(45.0 * i);
    models.push_back(model_of(scan, find_surface(scan)));
  }
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(align_scans(models, {}));
}
BENCHMARK(AlignScans)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace scanknit
