// The poses of pictures of a thing on a turntable.
#pragma once

#include "core/result.h"
#include "fusion/silhouette/silhouette_axis.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/silhouettes/silhouette_views.h"

namespace scanknit {

struct TurnedViews {
  SilhouetteAxis axis;
  TurntableResult table;  ///< what the report says of it
};

/// Finds the axis, and gives each view its pose round it. Angles are those of ScanJob::angles, else turntable.step for
/// each picture, else the pictures share a whole turn evenly. Errors: kConfig for an angle file that cannot be read or
/// has too few lines; kUsage for turntable.rpm, which needs times; those of find_silhouette_axis().
[[nodiscard]] Result<TurnedViews> turn_views(const ScanJob& job, double distance_m, SilhouettePictures& read);

}  // namespace scanknit
