// scan_in_bricks: a scan whose volume is larger than the memory.
#pragma once

#include <optional>

#include "scan/scan_job.h"
#include "scan/scan_pass.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Makes of frames with known poses what scan_walk() makes of them with enough memory, byte for byte. The volume stays
/// within its part of fusion.memory_budget: regions that the camera does not see go to files beside the first mesh
/// (PagedVolume), and the surface is extracted from these files, a few layers at a time. The mesh is in memory as a
/// whole. The job must pass check_bricks(), or check_coarse_bricks(): a mesh that is closed, or too large to be
/// simplified, is made of voxels of twice the size or more (finish/coarse_volume.h), with a warning. Nothing: a few
/// frames alone exceed the budget, and nothing was written; use scan_in_parts(). Outcomes: those of scan_walk();
/// kOutput for a full disk.
[[nodiscard]] std::optional<ScanResult> scan_in_pages(const ScanJob& job, const PassInput& input, ScanSession& session);

/// The same for any budget, in the parts that fusion.bricks asks for: plans which part of space each frame changes, and
/// fuses one part after the other into a file. Reads the frames once for the plan, and again for each group of parts
/// that the budget has room for. A stop request while planning is an error (kInput); later, the mesh has the parts that
/// were fused. Other outcomes: as above; kBudget for a brick of fusion.bricks that exceeds the budget; kInput when the
/// recording changes meanwhile, or a file of a part is damaged.
[[nodiscard]] ScanResult scan_in_parts(const ScanJob& job, const PassInput& input, ScanSession& session);

}  // namespace scanknit
