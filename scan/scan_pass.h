// ScanPass: once through the frames of a scan, from the first frame to the files. docs/architecture.md draws it.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "acquire/frame_source.h"
#include "core/axes.h"
#include "core/result.h"
#include "scan/frames/frame_archive.h"
#include "scan/frames/frame_intake.h"
#include "scan/mesh/mesh_scan.h"
#include "scan/reconstruction.h"
#include "scan/refine/pose_refiner.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// What a pass reads, and how.
struct PassInput {
  FrameSource& source;
  const FrameArchive& archive;      ///< has the same frames, once they are over
  std::stop_token stop = {};        ///< ends the frames; what comes after them is ended by the session's
  bool comes_by_itself = false;     ///< frames come whether they are taken or not: a paused scan lets them pass
  bool writes_tracked_mesh = true;  ///< before poses are refined; else nothing is written unless they are
  FrameCounts counted = {};         ///< frames of the scan that this pass does not have
  CropBox crop = {};
  std::function<LossCounters()> losses = {};  ///< of a scanner, so far
};

class ScanPass {
 public:
  /// All references outlive it.
  ScanPass(const ScanJob& job, const PassInput& input, PoseRefiner& refiner, ScanSession& session);

  /// Tracks and fuses all frames and writes the mesh; where the refiner has better poses, fuses all frames again at
  /// these and writes the mesh again; then bakes the texture. A stop request, or a person's, ends the frames: what has
  /// been fused becomes the mesh. Errors: kInput without a usable frame; kTooLittle when tracking was lost; kBudget;
  /// kMesh for an empty mesh; kOutput.
  [[nodiscard]] Result<void> run();

  /// Of the frames that were read; valid after run().
  [[nodiscard]] const FrameIntake& intake() const { return intake_; }
  [[nodiscard]] const CropBox& crop() const { return crop_; }

  /// Writes what was made and found out, also after an error, into `result`.
  void describe(ScanResult& result) const;

 private:
  [[nodiscard]] Result<void> begin();
  [[nodiscard]] Result<void> track_and_fuse();
  [[nodiscard]] Result<void> write_tracked();
  [[nodiscard]] Result<void> refine();
  [[nodiscard]] Result<bool> fuse_again(const Trajectory& trajectory);
  [[nodiscard]] Result<void> write_texture();

  [[nodiscard]] Result<void> add(Frame& frame);
  [[nodiscard]] Result<void> write_mesh();
  [[nodiscard]] Result<void> write_volume_and_trajectory();
  [[nodiscard]] ScanState state();
  void enter(ScanPhase phase);
  void enter_phase_of_frames();

  // What a person asks for.
  void carry_out_commands();
  void carry_out(const ScanCommand& command);
  void wait_while_paused();
  [[nodiscard]] Result<void> start_over();
  [[nodiscard]] Result<void> export_now(FilesByKind& files);

  const ScanJob& job_;
  PassInput input_;
  PoseRefiner& refiner_;
  ScanSession& session_;
  FrameIntake intake_;
  std::optional<Reconstruction> scan_;
  ScanPhase phase_ = ScanPhase::kWaiting;
  CropBox crop_;
  Result<void> tracking_verdict_;
  std::optional<WrittenMesh> written_;
  VolumeResult volume_;
  MeshResult mesh_;
  std::optional<TextureResult> texture_;
  FilesByKind files_;
};

}  // namespace scanknit
