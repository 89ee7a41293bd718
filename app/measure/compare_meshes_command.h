// `distance` with a mesh as the reference.
#pragma once

#include "app/commands.h"

namespace scanknit {

/// Returns the exit code: that of kMesh where the tolerance is not kept.
[[nodiscard]] int compare_meshes_command(const DistanceArguments& arguments, const CommonArguments& common);

}  // namespace scanknit
