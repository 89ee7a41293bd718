// Reconstruction: a volume that grows frame by frame, and the mesh that is made of it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "acquire/frame_source.h"
#include "app/scan/depth_samples.h"
#include "app/scan/finish_surface.h"
#include "app/scan/frame_intake.h"
#include "app/scan/fuse_again.h"
#include "app/scan/pipeline.h"
#include "app/scan/pose_finder.h"
#include "app/scan/texture_output.h"
#include "core/result.h"
#include "fusion/loops/loop_closure.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// The warning of EmptyCrop::kIgnored.
inline constexpr const char* kCropIgnored =
    "nothing lay within the crop box of the live view: the whole mesh was written";

/// The warning when a turntable is refined.
inline constexpr const char* kCropGone =
    "the crop box of the live view was drawn in the world of the tracked frames: the refined mesh is whole, and "
    "finish.crop cuts it";

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

  /// Done to each frame from now on, after the filter.
  void edit_frames(FrameEdit edit) { edit_ = std::move(edit); }

  /// Another volume of the same frames takes the place of what has been fused; the volume keeps its address.
  void replace_volume(TsdfVolume volume) { volume_ = std::move(volume); }

  /// As if nothing had been fused; the volume keeps its address. Errors: TsdfVolume::create().
  [[nodiscard]] Result<void> start_over();

  /// Outside of `box` nothing is meshed; world, metres.
  void crop(const std::optional<Eigen::AlignedBox3d>& box) { crop_ = box; }
  [[nodiscard]] const std::optional<Eigen::AlignedBox3d>& crop() const { return crop_; }

  /// The mesh of what has been fused, to all files of the job; `report` tells of it. Errors: kTooLittle before the
  /// first frame; kMesh where there is no surface; kOutput.
  [[nodiscard]] Result<WrittenMesh> write_mesh(RunReport& report, EmptyCrop empty_crop) const;

  /// Looks for places that the walk came back to; nothing unless poses are tracked and fusion.loop_closure is on.
  [[nodiscard]] std::optional<LoopClosure> find_loops();

  /// Tracks these frames of `source` again with nothing in the volume but what they show, and takes the walk from there
  /// along with them; the volume stays as it is. Frames after one at which that is lost keep their steps. Errors:
  /// track_alone().
  [[nodiscard]] Result<void> track_again(const FrameRange& frames, FrameSource& source, std::stop_token stop);

  /// The frames of `source`, which are those that were fused, again at these poses, in a volume that is empty at first
  /// and keeps its address. Returns how far the camera that moves most does, metres. Errors: fuse_again(); kInput when
  /// not all of them are there again.
  [[nodiscard]] Result<double> fuse_at(const std::vector<Pose>& T_world_cameras, FrameSource& source,
                                       std::stop_token stop, Console& console);

  /// What the job asks for beside the mesh. Errors: kOutput.
  [[nodiscard]] Result<void> write_volume();
  [[nodiscard]] Result<void> write_trajectory();

  /// Of a frame that was fused, by its place among them.
  [[nodiscard]] std::uint64_t sequence_of(std::size_t fused) const { return fused_[fused]; }

  [[nodiscard]] TsdfVolume& volume() { return volume_; }

 private:
  [[nodiscard]] Result<FinishedSurface> surface(EmptyCrop empty_crop, RunReport& report) const;
  Reconstruction(const Job& job, const RecordingInfo& info, FrameIntake& intake, RunReport& report, TsdfVolume volume)
      : job_(job), info_(info), intake_(intake), report_(report), volume_(std::move(volume)), poses_(info.poses) {
    expect_loops();
  }
  void expect_loops();
  void note_for_loops(const Frame& frame, const Pose& T_world_camera);

  const Job& job_;
  const RecordingInfo& info_;
  FrameIntake& intake_;
  RunReport& report_;
  TsdfVolume volume_;
  PoseFinder poses_;
  std::optional<Eigen::AlignedBox3d> crop_;
  FrameEdit edit_;
  std::vector<std::uint64_t> fused_;  ///< sequence numbers
  DepthSamples samples_;              ///< when a report is written
  std::optional<KeyFrames> keys_;     ///< when loops are looked for
  bool was_lost_ = false;             ///< since the last frame that was fused
};

}  // namespace scanknit
