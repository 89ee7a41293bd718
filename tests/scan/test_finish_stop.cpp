// Finishing that is interrupted.
#include <gtest/gtest.h>

#include <latch>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "scan/mesh/finish_surface.h"
#include "tests/core/sample_meshes.h"

namespace scanknit {
namespace {

ScanConfig steps_wanted() {
  ScanConfig config;
  config.finish.smooth_steps = 1000;
  config.finish.triangles = 500;
  config.finish.origin = OriginMode::kGround;
  return config;
}

Surface surface_of(const Mesh& mesh) {
  Surface surface;
  surface.mesh = mesh;
  return surface;
}

struct Attempt {
  Mesh mesh;
  std::vector<std::string> refused;
};

/// Asked to stop by another thread, which first lets others work `yields` times.
Attempt stopped_after(std::size_t yields, const Mesh& mesh) {
  Attempt attempt;
  std::latch begins(2);
  std::stop_source source;
  const std::jthread stopper([&] {
    begins.arrive_and_wait();
    for (std::size_t i = 0; i < yields; ++i) std::this_thread::yield();
    source.request_stop();
  });
  begins.arrive_and_wait();
  const ScanConfig config = steps_wanted();
  ScanObserver observer;
  ScanSession session(observer, {});
  FinishedSurface finished = finished_mesh(surface_of(mesh), {config, UpAxis::kZ, 1, source.get_token()}, session);
  EXPECT_TRUE(finished.outcome);
  attempt.mesh = std::move(finished.surface.mesh);
  for (const auto& step : finished.steps->steps) {
    const bool is_interrupted = step.refused.find("interrupted") != std::string::npos;
    EXPECT_TRUE(is_interrupted || (step.refused.empty() && attempt.refused.empty()))
        << to_string(step.step);  // the last ones
    if (is_interrupted) attempt.refused.push_back(to_string(step.step));
  }
  EXPECT_EQ(finished.warnings.size(), attempt.refused.size());
  return attempt;
}

/// Nearly all of the time is spent in smoothing: sooner or later that is where it is stopped.
TEST(FinishStop, WhatIsLeftIsNotDoneAndTheMeshIsWhole) {
  const Mesh mesh = test::sphere();
  constexpr std::size_t kMostYields = std::size_t{1} << 26;
  for (std::size_t yields = 1;; yields *= 2) {
    ASSERT_LE(yields, kMostYields) << "never stopped while it smoothed";
    const Attempt attempt = stopped_after(yields, mesh);
    if (attempt.refused.empty() || attempt.refused.front() != "smooth") continue;
    EXPECT_EQ(attempt.refused, (std::vector<std::string>{"smooth", "simplify", "place"}));
    EXPECT_TRUE(attempt.mesh.positions_m == mesh.positions_m);
    EXPECT_TRUE(attempt.mesh.triangles == mesh.triangles);
    return;
  }
}

/// An observer that keeps what it is told.
struct Listener : ScanObserver {
  void on_warning(const ScanWarning& warning) override { heard.push_back(warning.text); }
  std::vector<std::string> heard;
};

TEST(FinishedMesh, HasItsOwnWarningsAndItsObserverHearsEachOnce) {
  ScanConfig config;
  config.finish.triangles = 1;  // with as few, a closed mesh would be none
  Listener listener;
  ScanSession session(listener, {});
  for (int i = 0; i < 2; ++i) {
    const FinishedSurface finished = finished_mesh(surface_of(test::sphere()), {config, UpAxis::kZ}, session);
    ASSERT_EQ(finished.warnings.size(), 1u);
    EXPECT_EQ(finished.warnings.front().code, WarningCode::kFinishStep);
  }
  EXPECT_EQ(listener.heard.size(), 1u);
  EXPECT_TRUE(session.warnings().empty());
}

/// A capture ends by Ctrl-C, and is finished then.
TEST(FinishStop, AStopFromBeforeChangesNothing) {
  std::stop_source source;
  source.request_stop();
  ScanConfig config = steps_wanted();
  config.finish.smooth_steps = 1;
  ScanObserver observer;
  ScanSession session(observer, {});
  const FinishedSurface finished =
      finished_mesh(surface_of(test::sphere()), {config, UpAxis::kZ, 1, source.get_token()}, session);
  ASSERT_TRUE(finished.outcome);
  EXPECT_LT(finished.surface.mesh.triangles.size(), 1000u);
  for (const auto& step : finished.steps->steps) EXPECT_EQ(step.refused, "") << to_string(step.step);
  EXPECT_TRUE(session.warnings().empty());
}

}  // namespace
}  // namespace scanknit
