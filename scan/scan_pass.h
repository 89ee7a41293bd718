// ScanPass: one pass through the frames of a scan, from the first frame to the files. docs/architecture.md draws it.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <stop_token>
#include <vector>

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

/// When a pass gives up and writes nothing. A pass of a scan that was stopped never does.
struct PassLimits {
  /// At its end the pass gives up if its frames fit worse in quick turns: ScanPass::misfit().
  double most_misfit = 1;
  /// The pass gives up as soon as it has lost more frames, before any of them is looked for again.
  std::size_t most_lost_before_search = std::numeric_limits<std::size_t>::max();
  bool gives_up_when_full = false;  ///< as soon as the volume has reached its budget
};

/// The frames of a pass, and how to take them.
struct PassInput {
  FrameSource& source;
  const FrameArchive& archive;  ///< gives the same frames again, after they have ended
  std::stop_token stop = {};    ///< ends the frames; the session's stop token ends the steps after them
  bool is_paced = false;        ///< frames come at their own pace: a paused scan skips them
  PassLimits limits = {};
  bool makes_mesh = true;           ///< else the pass ends when the poses are known
  bool writes_tracked_mesh = true;  ///< write a mesh before poses are refined; else only refined meshes are written
  FrameCounts counted = {};         ///< counts of the scan's frames that this pass does not have
  CropBox crop = {};
  std::function<LossCounters()> losses = {};  ///< the scanner's losses so far
};

class ScanPass {
 public:
  /// All references outlive it.
  ScanPass(const ScanJob& job, const PassInput& input, PoseRefiner& refiner, ScanSession& session);

  /// Tracks and fuses all frames and writes the mesh; if the refiner finds better poses, fuses all frames again at
  /// these and writes the mesh again; then bakes the texture. A stop request, or the user's command, ends the frames:
  /// what has been fused becomes the mesh. Errors: kInput without a usable frame; kTooLittle when tracking was lost;
  /// kBudget; kMesh for an empty mesh; kOutput.
  [[nodiscard]] Result<void> run();

  /// Counts of the frames that were read; valid after run().
  [[nodiscard]] const FrameIntake& intake() const { return intake_; }
  [[nodiscard]] const CropBox& crop() const { return crop_; }
  /// True after run() when it gave up: PassInput::limits.
  [[nodiscard]] bool has_given_up() const { return has_given_up_; }
  /// Of the frames in quick turns, the mean share that does not agree with the model. Lost frames that saw enough count
  /// as 1, wherever they are. Nothing for fewer than five of both, without a quick turn, and where poses are given.
  [[nodiscard]] std::optional<double> misfit() const { return misfit_; }

  /// Reconstruction::fused_order(), and ::sample_sequences(); empty before the first frame.
  [[nodiscard]] std::vector<std::uint64_t> fused_order() const;
  [[nodiscard]] std::vector<std::uint64_t> sample_sequences() const;

  /// Everything that was made and measured, also after an error, which the result does not have.
  [[nodiscard]] ScanResult result() const;

 private:
  enum class IsLastMesh { kNo, kYes };  ///< kYes: the pass does not need the volume after it

  [[nodiscard]] Result<void> begin();
  [[nodiscard]] Result<void> track_and_fuse();
  void find_lost();
  [[nodiscard]] Result<void> check_misfit();
  [[nodiscard]] Result<void> give_up();
  [[nodiscard]] Result<void> write_tracked();
  [[nodiscard]] Result<void> write_tracked_mesh(IsLastMesh is_last);
  [[nodiscard]] Result<void> refine();
  [[nodiscard]] Result<void> extract_and_write();
  [[nodiscard]] Error after_tracked_mesh(Error error);
  [[nodiscard]] Result<void> make_room();
  [[nodiscard]] Result<void> empty_volume();
  [[nodiscard]] Result<bool> fuse_again(const Trajectory& trajectory);
  [[nodiscard]] Result<void> write_texture();

  [[nodiscard]] Result<void> add(Frame& frame);
  [[nodiscard]] Result<void> carve_gaps();
  [[nodiscard]] Result<void> write_mesh(IsLastMesh is_last);
  [[nodiscard]] Result<void> write_volume_and_trajectory();
  [[nodiscard]] ScanState state();
  void enter(ScanPhase phase);
  void enter_phase_of_frames();

  // Commands of the user.
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
  bool has_given_up_ = false;
  std::optional<double> misfit_;
  ScanPhase phase_ = ScanPhase::kWaiting;
  CropBox crop_;
  bool is_refined_ = false;  ///< the volume holds the refined poses
  bool was_full_ = false;    ///< the volume reached its budget while the frames came
  Result<void> tracking_verdict_;
  Result<void> room_;  ///< make_room()'s
  std::optional<WrittenMesh> written_;
  VolumeResult volume_;
  MeshResult mesh_;
  std::optional<SilhouetteResult> silhouettes_;
  std::optional<TextureResult> texture_;
  FilesByKind files_;
};

}  // namespace scanknit
