// extract_volume: makes a mesh of a volume file.
#pragma once

#include <stop_token>

#include "extract/extract_config.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Where the isovalue comes from.
enum class IsovalueSetting {
  kGiven,    ///< in the job's extract.isovalue
  kAuto,     ///< proposed from the volume's values; 0 for signed distances
  kNotGiven  ///< 0 for signed distances; for any other volume an error that gives the range of its values
};

struct VolumeRequest {
  VolumeOptions options;
  IsovalueSetting isovalue = IsovalueSetting::kNotGiven;
};

/// Makes a mesh of a volume file: OpenVDB (.vdb), DICOM, NRRD, MetaImage, NIfTI-1, a folder of PNG or TIFF slices, or
/// raw samples. Reads a few slices at a time when the samples need more than half of extract.memory_budget. The mesh
/// has the volume's own coordinates. ScanResult::outcome: kOutput before any work; kUsage without an isovalue, and for
/// options that do not belong to the volume; kInput, also when an isovalue must be found and no sample is finite;
/// kBudget; kMesh for an empty mesh. `stop` ends only the finishing of the mesh.
[[nodiscard]] ScanResult extract_volume(const ScanJob& job, const VolumeRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

}  // namespace scanknit
