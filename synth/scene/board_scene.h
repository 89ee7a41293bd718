// The scene `calibration_board`: a board for `calibrate camera`, seen from all sides.
#pragma once

#include <memory>

#include "calibrate/target/calibration_target.h"
#include "core/result.h"
#include "synth/scene/scene.h"

namespace scanknit {

inline constexpr CalibrationTarget kSceneBoard{TargetType::kAprilGrid, 6, 4, 0.04};

/// As scene_names.h describes it. The board's frame has the world's axes. Error (kInternal): target_shapes()'s.
[[nodiscard]] Result<std::unique_ptr<SyntheticScene>> board_scene();

}  // namespace scanknit
