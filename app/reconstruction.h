// Reconstruction: a volume that grows frame by frame, and the mesh that is made of it.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acquire/frame_source.h"
#include "app/frame_intake.h"
#include "app/pipeline.h"
#include "app/pose_finder.h"
#include "core/result.h"
#include "fusion/tsdf_volume.h"

namespace scanknit {

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

  /// The mesh of what has been fused, to all files of the job; `report` tells of it. Errors: kTooLittle before the
  /// first frame; kMesh where there is no surface; kOutput.
  [[nodiscard]] Result<void> write_mesh(RunReport& report) const;

  /// What the job asks for beside the mesh. Errors: kOutput.
  [[nodiscard]] Result<void> write_volume();
  [[nodiscard]] Result<void> write_trajectory();

  [[nodiscard]] TsdfVolume& volume() { return volume_; }

 private:
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
