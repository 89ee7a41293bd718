// Integrates one depth frame into a part of a volume.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/integrate/band_blocks.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/region_set.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// integrate(), but adds and updates only blocks of `part`. `number`: the frame's number among all frames that the
/// whole volume would integrate, from 1. Every block has then the very bits that it has in the whole volume, as no
/// block depends on another: provided that the budget is not reached, that frames come in order, and that none is left
/// out that BrickPlan gives for a region of the part.
[[nodiscard]] Result<IntegrateStats> integrate_part(const Frame& frame, const Pose& T_world_camera,
                                                    std::uint32_t number, const RegionSet& part, TsdfVolume& volume);

/// Gets the blocks that the next frame may observe and, unless null, the space in front of them, in which it may change
/// known blocks; makes sure that the volume has what is known of both, and room for the rest.
using MakeRoom = std::function<Result<void>(std::span<const BandBlock> band, const SpaceInFront* front)>;

/// integrate(), but calls `make_room` before anything is changed. Errors also: those of `make_room`; the frame is not
/// integrated then.
[[nodiscard]] Result<IntegrateStats> integrate_with_room(const Frame& frame, const Pose& T_world_camera,
                                                         const MakeRoom& make_room, TsdfVolume& volume);

}  // namespace scanknit
