// What comes of scans that were brought together: numbers, pictures, points, and a mesh.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/align/align_inputs.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

struct AlignedScans {
  const AlignInputs& inputs;
  const Alignment& alignment;
};

/// Tells of scans and pairs in `result`; with a folder, each pair becomes a picture in it. Errors: kOutput.
[[nodiscard]] Result<void> describe_alignment(const AlignedScans& scans,
                                              const std::optional<std::filesystem::path>& picture_folder,
                                              ScanSession& session, std::optional<AlignmentResult>& result);

/// All points, each scan in its place. Errors: kOutput.
[[nodiscard]] Result<void> write_aligned_points(const AlignedScans& scans, const std::filesystem::path& path,
                                                ScanSession& session);

/// Range scans and recordings in their places become one volume and its mesh.
class AlignedFusion {
 public:
  /// All references outlive it.
  AlignedFusion(const AlignedScans& scans, const ScanJob& job, ScanSession& session, ScanResult& result);

  /// Fuses, and writes all files of the job. `result` tells of it, also after an error. Errors: kTooLittle when it was
  /// interrupted before anything was fused; the recordings'; kMesh; kOutput.
  [[nodiscard]] Result<void> run();

 private:
  [[nodiscard]] Result<std::size_t> fuse(std::size_t scan, TsdfVolume& volume);
  [[nodiscard]] Result<void> write_poses();
  [[nodiscard]] Result<void> save(const TsdfVolume& volume);
  [[nodiscard]] Result<void> mesh(const TsdfVolume& volume);

  const AlignInputs& inputs_;
  const Alignment& alignment_;
  const ScanJob& job_;
  ScanSession& session_;
  ScanResult& result_;
};

}  // namespace scanknit
