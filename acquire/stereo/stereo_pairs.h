// The pairs of pictures of a stereo recording, with their times and poses. Private to the room.
#pragma once

#include <vector>

#include "acquire/replay/recording.h"
#include "acquire/stereo/stereo_rig.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// `colour` is the left picture, `depth` the right one; a pair that lacks its right one has a fault. Pairs have the
/// same name, or the same place where no name agrees. Times are in times.txt, else in the names; poses are the left
/// camera's, in trajectory.txt or trajectory.log. Errors (kInput): the two folders do not fit each other, a file cannot
/// be read.
[[nodiscard]] Result<std::vector<FrameEntry>> list_stereo_pairs(const StereoFolders& folders, const Limits& limits);

}  // namespace scanknit
