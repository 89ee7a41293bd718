// Several scans of one thing, brought together and meshed as one.
#pragma once

#include <stop_token>

#include "scan/align/align_request.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Reads all inputs, finds the place of each, and fuses range scans and recordings into one mesh. Meshes and point
/// clouds are brought to their places only. ScanResult::outcome: kOutput before any work; kInput; kTooLittle when a
/// scan has no place beside the first, or it was stopped; kMesh.
[[nodiscard]] ScanResult align_and_mesh(const ScanJob& job, const AlignRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

}  // namespace scanknit
