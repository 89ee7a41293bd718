// Registers several scans of one object and makes one mesh of them.
#pragma once

#include <stop_token>

#include "scan/align/align_request.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Reads all inputs, finds the pose of each, and fuses range scans and recordings into one mesh. Meshes and point
/// clouds only get a pose; they are not fused. ScanResult::outcome: kOutput before any work; kInput; kTooLittle when no
/// pose was found for a scan, or when the alignment was stopped; kMesh.
[[nodiscard]] ScanResult align_and_mesh(const ScanJob& job, const AlignRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

}  // namespace scanknit
