// The recordings of a rig as one.
#pragma once

#include <memory>

#include "acquire/acquire_config.h"
#include "acquire/frame_source.h"
#include "acquire/rig/rig_config.h"
#include "core/result.h"

namespace scanknit {

/// The frames of all cameras in the order of the rig's time, each at its camera's pose; in the order of their numbers
/// where a recording has no clock. They are numbered from 0, and so are those that config.from and to choose. A
/// recording that cannot be read is left out, and a warning (RecordingInfo::warnings) says so; of one that is damaged,
/// the frames that can be read are taken. What is known of the whole (sensor, first camera) is that of the first
/// recording that can be read. `format` is "rig". Errors: kConfig: acquire.poses asks for other poses than the known
/// ones; a calibration of another scanner; the first recording's, if none can be read.
[[nodiscard]] Result<std::unique_ptr<FrameSource>> open_rig(const Rig& rig, const AcquireConfig& config);

}  // namespace scanknit
