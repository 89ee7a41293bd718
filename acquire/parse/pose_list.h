// The poses of Open3D's and Redwood's folders (Choi, Zhou, Koltun 2015), one for each picture.
#pragma once

#include <vector>

#include "acquire/replay/folder.h"
#include "core/limits.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// True if there is a trajectory.log or a trajectory.json.
[[nodiscard]] bool has_pose_list(const Folder& folder);

/// Camera-to-world, in the order of the file; a pose that is none is an Error. Empty without such a file. Errors
/// (kInput): the file cannot be read.
[[nodiscard]] Result<std::vector<Result<Pose>>> read_pose_list(const Folder& folder, const Limits& limits);

}  // namespace scanknit
