// scan_classes: one pass over a recording with masks of classes, one mesh for each class.
#pragma once

#include <cstddef>
#include <stop_token>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// More classes are left out, with a warning.
inline constexpr std::size_t kMostClasses = 32;

/// scan_recording() of a job with `meshes_each_class`: fuses each class of the masks into a volume of its own, and
/// writes each file once for each class, with "_class3" behind its name; the trajectory once. Poses that the recording
/// does not have are tracked before, by all depth. The volumes share fusion.memory_budget: the class that comes first
/// takes what it needs first. A class without a mesh is a warning. Outcome: also kUsage without masks, and for what
/// does not apply: turntables. No texture is made.
[[nodiscard]] ScanResult scan_classes(const ScanJob& job, ScanObserver& observer, std::stop_token stop);

}  // namespace scanknit
