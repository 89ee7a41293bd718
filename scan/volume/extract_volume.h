// extract_volume: a volume's file becomes a mesh, in one call.
#pragma once

#include <stop_token>

#include "extract/extract_config.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Where the isovalue comes from.
enum class IsovalueWish {
  kGiven,  ///< ScanJob::config.extract
  kAuto,   ///< proposed from the volume's values; 0 for signed distances
  kUnsaid  ///< 0 for signed distances; of any other volume an error that shows its values
};

struct VolumeRequest {
  VolumeOptions options;
  IsovalueWish isovalue = IsovalueWish::kUnsaid;
};

/// A volume file becomes a mesh: OpenVDB (.vdb), DICOM, NRRD, MetaImage, NIfTI-1, a folder of PNG or TIFF slices, or
/// raw samples; a few slices at a time where the samples need more than half of extract.memory_budget. The mesh lies in
/// the volume's own coordinates. ScanResult::outcome: kOutput before any work; kUsage without an isovalue, and for
/// options that do not belong to the volume; kInput, also where the isovalue is sought and no sample is finite;
/// kBudget; kMesh for an empty mesh. `stop` ends the finishing of the mesh only.
[[nodiscard]] ScanResult extract_volume(const ScanJob& job, const VolumeRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

}  // namespace scanknit
