// Scenes with what makes real rooms hard: clutter, thin and glossy things, bare walls, great depth.
#pragma once

#include <memory>

#include "synth/scene/scene.h"

namespace scanknit {

// As scene_names.h describes them.
[[nodiscard]] std::unique_ptr<SyntheticScene> clutter_scene();
[[nodiscard]] std::unique_ptr<SyntheticScene> corridor_scene();
[[nodiscard]] std::unique_ptr<SyntheticScene> bare_wall_scene();
[[nodiscard]] std::unique_ptr<SyntheticScene> hall_scene();

}  // namespace scanknit
