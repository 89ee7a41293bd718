// The output of an alignment: numbers, pictures, points, and a mesh.
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

/// Scans and pairs in numbers. After an error, what was made before it.
struct DescribedAlignment {
  Result<void> outcome;
  AlignmentResult result;
};

/// With a folder, writes one picture of each pair into it. `outcome`: kOutput.
[[nodiscard]] DescribedAlignment describe_alignment(const AlignedScans& scans,
                                                    const std::optional<std::filesystem::path>& picture_folder,
                                                    ScanSession& session);

/// Writes the points of all scans, in one frame. Errors: kOutput.
[[nodiscard]] Result<void> write_aligned_points(const AlignedScans& scans, const std::filesystem::path& path,
                                                ScanSession& session);

/// The volume of aligned scans, its mesh, and the files. After an error, what was made before it.
struct FusedScans {
  Result<void> outcome;
  std::size_t frames = 0;  ///< that were fused; a range scan counts as one
  VolumeResult volume;
  MeshResult mesh;
  FilesByKind files;  ///< but those of the mesh
};

/// Fuses the aligned range scans and recordings into one volume and makes its mesh.
class AlignedFusion {
 public:
  /// All references outlive it.
  AlignedFusion(const AlignedScans& scans, const ScanJob& job, ScanSession& session);

  /// Fuses, and writes all files of the job; to be called once. `outcome`: kTooLittle when a stop came before anything
  /// was fused; those of the recordings; kMesh; kOutput.
  [[nodiscard]] FusedScans run();

 private:
  [[nodiscard]] Result<void> fuse_and_write();
  [[nodiscard]] Result<std::size_t> fuse(std::size_t scan, TsdfVolume& volume);
  [[nodiscard]] Result<void> write_poses();
  [[nodiscard]] Result<void> save(const TsdfVolume& volume);
  [[nodiscard]] Result<void> mesh(const TsdfVolume& volume);

  const AlignInputs& inputs_;
  const Alignment& alignment_;
  const ScanJob& job_;
  ScanSession& session_;
  FusedScans made_;
};

}  // namespace scanknit
