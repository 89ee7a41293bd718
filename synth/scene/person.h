// A person in front of the camera, who moves while the scene stays as it is.
#pragma once

#include <memory>
#include <string_view>

#include "synth/scene/person_names.h"
#include "synth/scene/scene.h"

namespace scanknit {

/// The person alone, as a scene at one moment. `scene` says where there is room for one; on a scene that has none the
/// person is 1.3 m behind the plan's origin. Null for nobody. The person is not part of the truth.
[[nodiscard]] std::unique_ptr<SyntheticScene> person_at(PersonKind kind, std::string_view scene, double time_s);

}  // namespace scanknit
