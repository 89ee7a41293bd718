// scan_in_bricks: a scan whose volume is larger than the memory.
#pragma once

#include "scan/scan_job.h"
#include "scan/scan_pass.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Makes of frames with known poses what scan_walk() makes of them with enough memory, byte for byte: plans which part
/// of space each frame changes, fuses one part after the other into a file beside the first mesh, and extracts the
/// surface from these files, a few layers at a time. Reads the frames once for the plan, and again for each part. The
/// parts, and the layers, stay within fusion.memory_budget; the mesh is in memory as a whole. The job must pass
/// check_bricks(). A stop request while planning is an error (kInput); later, the mesh has the parts that were fused.
/// Other outcomes: those of scan_walk(); kBudget for a brick of fusion.bricks that exceeds the budget; kInput when the
/// recording changes meanwhile, or a file of a part is damaged; kOutput for a full disk.
[[nodiscard]] ScanResult scan_in_bricks(const ScanJob& job, const PassInput& input, ScanSession& session);

}  // namespace scanknit
