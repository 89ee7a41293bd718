// Makes a mesh of a volume.
#pragma once

#include <memory>
#include <stop_token>

#include "core/result.h"
#include "extract/volume/slice_reader.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Where the isovalue comes from.
enum class IsovalueWish {
  kGiven,    ///< in the job's extract.isovalue
  kAuto,     ///< proposed from the volume's values; 0 for signed distances
  kNotGiven  ///< 0 for signed distances; for any other volume an error that gives the range of its values
};

struct VolumeRequest {
  VolumeOptions options;
  IsovalueWish isovalue = IsovalueWish::kNotGiven;
};

/// Makes a mesh of a volume file: an OpenVDB file (.vdb), or any format of open_volume(). Reads a few slices at a time
/// when the samples need more than half of extract.memory_budget. The mesh has the volume's own coordinates.
/// ScanResult::outcome: kOutput before any work; kUsage without an isovalue, and for options that do not belong to the
/// volume; kInput, also when an isovalue must be found and no sample is finite; kBudget; kMesh for an empty mesh.
/// `stop` ends only the finishing of the mesh.
[[nodiscard]] ScanResult extract_volume(const ScanJob& job, const VolumeRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

/// open_volume() within extract.memory_budget; its errors name the program's options.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_volume_file(const std::filesystem::path& path,
                                                                    VolumeOptions options, const ExtractConfig& config);

/// True when the file's name ends in .vdb.
[[nodiscard]] bool is_vdb(const std::filesystem::path& path);

/// kUsage when an option is set that does not apply to OpenVDB files.
[[nodiscard]] Result<void> refuse_options_for_vdb(const std::filesystem::path& path, const VolumeOptions& options);

}  // namespace scanknit
