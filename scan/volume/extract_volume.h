// A volume becomes a mesh.
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
  kGiven,  ///< Config::extract
  kAuto,   ///< proposed from the volume's values; 0 for signed distances
  kUnsaid  ///< 0 for signed distances; of any other volume an error that shows its values
};

struct VolumeRequest {
  VolumeOptions options;
  IsovalueWish isovalue = IsovalueWish::kUnsaid;
};

/// A volume file becomes a mesh: an OpenVDB file (.vdb), or whatever open_volume() knows; a few slices at a time where
/// the samples need more than half of extract.memory_budget. The mesh lies in the volume's own coordinates.
/// ScanResult::outcome: kOutput before any work; kUsage without an isovalue, and for options that do not belong to the
/// volume; kInput, also where the isovalue is sought and no sample is finite; kBudget; kMesh for an empty mesh. `stop`
/// ends the finishing of the mesh only.
[[nodiscard]] ScanResult extract_volume(const ScanJob& job, const VolumeRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

/// open_volume() within extract.memory_budget; its errors name the program's options.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_volume_file(const std::filesystem::path& path,
                                                                    VolumeOptions options, const ExtractConfig& config);

/// By its ending.
[[nodiscard]] bool is_vdb(const std::filesystem::path& path);

/// kUsage where an option is for other volumes than OpenVDB's.
[[nodiscard]] Result<void> refuse_options_for_vdb(const std::filesystem::path& path, const VolumeOptions& options);

}  // namespace scanknit
