// The first frames of a walk round a synthetic scene, small and without noise, as the tracker takes them.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <utility>
#include <variant>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "fusion/fusion_config.h"
#include "synth/scene/scene.h"
#include "synth/synthetic_source.h"

namespace scanknit::test {

/// `frames` of the `frames_a_round` that a walk all round `scene_name` takes. `change(i, frame)` is done to frame i
/// before it is filtered.
inline std::vector<Frame> small_scan(
    const char* scene_name, std::size_t frames, int frames_a_round, const NoiseModel& noise,
    const std::function<void(std::size_t, Frame&)>& change = [](std::size_t, Frame&) {}) {
  SynthConfig config;
  config.frames = frames_a_round;
  config.intrinsics = {160, 120, 131.25, 131.25, 79.5, 59.5};
  std::vector<Frame> scan;
  auto scene = make_scene(scene_name);
  if (!scene) return scan;
  const auto source = SyntheticSource::create(*std::move(scene), config);
  if (!source) return scan;
  while (scan.size() < frames) {
    FrameEvent event = (*source)->next({});
    if (!std::holds_alternative<Frame>(event)) break;
    scan.push_back(std::get<Frame>(std::move(event)));
    change(scan.size() - 1, scan.back());
    if (!filter_frame(scan.back(), AcquireConfig{}, noise)) break;
  }
  return scan;
}

}  // namespace scanknit::test
