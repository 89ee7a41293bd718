// Reconstruction: a volume that grows frame by frame, and the mesh that is made of it.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acquire/frame_source.h"
#include "app/frame_intake.h"
#include "app/pipeline.h"
#include "app/pose_finder.h"
#include "core/result.h"
#include "extract/extract_surface.h"
#include "fusion/tsdf_volume.h"

namespace scanknit {

/// The warning of EmptyCrop::kIgnored.
inline constexpr const char* kCropIgnored =
    "nothing lay within the crop box of the live view: the whole mesh was written";

/// What becomes of a crop box that holds nothing of the mesh.
enum class EmptyCrop {
  kRefused,  ///< an error: the box can still be changed
  kIgnored,  ///< the whole mesh is written, with a warning in the report: a scan is never lost
};

class Reconstruction {
 public:
  /// All references outlive it. Errors: TsdfVolume::create().
  [[nodiscard]] static Result<Reconstruction> create(const Job& job, const RecordingInfo& info, FrameIntake& intake,
                                                     RunReport& report);

  /// Filters the frame, finds its pose and fuses it. The pose, or nothing for a frame that was left out, which the
  /// report tells. Errors: what ends the scan.
  [[nodiscard]] Result<std::optional<Pose>> add(Frame& frame);

  /// As if nothing had been fused; the volume keeps its address. Errors: TsdfVolume::create().
  [[nodiscard]] Result<void> start_over();

  /// Outside of `box` nothing is meshed; world, metres.
  void crop(const std::optional<Eigen::AlignedBox3d>& box) { crop_ = box; }
  [[nodiscard]] const std::optional<Eigen::AlignedBox3d>& crop() const { return crop_; }

  /// The mesh of what has been fused, to all files of the job; `report` tells of it. Errors: kTooLittle before the
  /// first frame; kMesh where there is no surface; kOutput.
  [[nodiscard]] Result<void> write_mesh(RunReport& report, EmptyCrop empty_crop) const;

  /// What the job asks for beside the mesh. Errors: kOutput.
  [[nodiscard]] Result<void> write_volume();
  [[nodiscard]] Result<void> write_trajectory();

  [[nodiscard]] TsdfVolume& volume() { return volume_; }

 private:
  [[nodiscard]] Result<Surface> surface(EmptyCrop empty_crop, RunReport& report) const;
  Reconstruction(const Job& job, const RecordingInfo& info, FrameIntake& intake, RunReport& report, TsdfVolume volume)
      : job_(job), info_(info), intake_(intake), report_(report), volume_(std::move(volume)), poses_(info.poses) {}

  const Job& job_;
  const RecordingInfo& info_;
  FrameIntake& intake_;
  RunReport& report_;
  TsdfVolume volume_;
  PoseFinder poses_;
  std::optional<Eigen::AlignedBox3d> crop_;
};

}  // namespace scanknit
