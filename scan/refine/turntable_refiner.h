// TurntableRefiner: finds axis and angles of a turntable from its frames, and cuts the volume to the object.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "acquire/convert/cut_recording.h"
#include "core/result.h"
#include "fusion/picture_part.h"
#include "fusion/turntable/look_through.h"
#include "fusion/turntable/still_scene.h"
#include "fusion/turntable/turntable_pairs.h"
#include "fusion/turntable/turntable_prior.h"
#include "fusion/turntable/turntable_space.h"
#include "scan/frames/frame_archive.h"
#include "scan/refine/known_angles.h"
#include "scan/refine/pose_refiner.h"
#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// The refined world's origin is where the axis meets the disc, its -y is up; poses of the recording stay as they are.
class TurntableRefiner final : public PoseRefiner {
 public:
  /// `archive` has the job's frames and is read several times. `poses`: with kRecording the recording's poses are
  /// exact, and only the cut is made; else poses are tracked. All references outlive it.
  TurntableRefiner(const ScanJob& job, PoseMode poses, const FrameArchive& archive, ScanSession& session);

  /// Learns from about fifty frames what stands still. Errors: those of the recording; kConfig for known angles that do
  /// not fit the recording.
  [[nodiscard]] Result<void> prepare() override;
  /// Removes from a filtered frame what stands still, and crops the picture to the part where something moves. Does
  /// nothing when poses are known.
  void edit_for_tracking(Frame& frame) const override;
  /// True: the turn joins frames for which tracking was lost.
  [[nodiscard]] bool recovers_lost_scans() const override { return true; }
  /// Finds the axis and all angles.
  [[nodiscard]] Result<std::optional<Trajectory>> refine(const TrackedWalk& walk) override;
  void edit_for_fusion(Frame& frame) override;
  /// Cuts the volume to the space in which the object turned.
  [[nodiscard]] Result<void> accept(TsdfVolume& volume) override;
  [[nodiscard]] Result<void> reject(const Result<std::size_t>& fused) override;
  [[nodiscard]] std::function<bool(const Eigen::Vector3d&)> kept_space() const override;
  [[nodiscard]] bool moves_the_world() const override { return true; }
  /// If the scan ended between prepare() and refine(), the reason says so.
  [[nodiscard]] RefinerResult result() const override;

 private:
  /// All frames that were read while tracking.
  struct Nodes {
    std::vector<std::uint64_t> sequences;
    std::vector<double> stamps;
    std::vector<std::int64_t> times_ns;  ///< 0 without a clock
    std::vector<bool> is_tracked;        ///< the other frames have the angles of angles_of_all()
    TurntableMotion motion;
    std::vector<Pose> T_world_camera;  ///< the recording's poses, if it has any
    [[nodiscard]] std::optional<std::size_t> find(std::uint64_t sequence) const;
  };
  using Visit = std::function<Result<void>(Frame&)>;

  [[nodiscard]] bool changes_frames() const { return !has_poses_ && !still_.empty(); }
  [[nodiscard]] Result<void> read_frames(std::size_t every, const Visit& visit) const;
  void add_sample(Frame& frame);
  [[nodiscard]] std::vector<DepthImage> moving_parts() const;
  [[nodiscard]] bool begin_nodes(const TrackedWalk& walk);
  [[nodiscard]] bool find_space_of_object();
  [[nodiscard]] Result<bool> find_motion(std::set<std::size_t>& solved);
  [[nodiscard]] Result<bool> find_pairs(TurntablePairs& pairs);
  [[nodiscard]] Result<void> measure_pairs(TurntablePairs& pairs);
  [[nodiscard]] Result<void> check_known_angles(const RecordingInfo& info);
  [[nodiscard]] std::optional<AnglePrior> checked_prior(AnglePrior prior, const TurntableSolution& seen,
                                                        const std::vector<std::size_t>& parts);
  void join_by_angles(std::vector<std::size_t>& parts);
  void warn_of_left_out(const std::set<std::size_t>& solved);
  void warn(std::string text) { session_.warn(WarningCode::kTurntable, std::move(text)); }
  [[nodiscard]] bool check_solution(const TurntableSolution& solution, const TurntablePairs& pairs);
  void describe_solution(const TurntableSolution& solution, const TurntablePairs& pairs);
  [[nodiscard]] Result<std::set<std::size_t>> solved_frames();
  [[nodiscard]] Trajectory trajectory_of(const std::set<std::size_t>& solved);
  void add_witnesses();
  void cut_to_object(Frame& frame, double angle_rad);
  [[nodiscard]] Result<void> record_cut(const Frame& frame);
  [[nodiscard]] bool give_up(const char* reason);

  const ScanJob& job_;
  const ScanConfig& config_;
  bool has_poses_;
  const FrameArchive& archive_;
  ScanSession& session_;
  bool is_prepared_ = false;
  TurntableResult result_;
  KnownAngles known_;
  CameraIntrinsics camera_;
  std::vector<DepthImage> samples_;
  std::vector<std::uint64_t> sample_sequences_;
  StillScene still_;
  std::optional<PixelRect> moving_rect_;  ///< nothing: the whole picture
  double depth_m_ = 1;                    ///< typical depth of what moves
  Nodes nodes_;
  std::optional<TurntableSpace> space_;
  std::optional<PixelRect> space_rect_;
  std::optional<LookThrough> look_through_;
  Pose T_world_object_ = Pose::Identity();
  PosesBySequence poses_;                      ///< poses at which frames are fused again
  std::optional<CutRecording> cut_recording_;  ///< receives the frames while they are fused again
  Result<void> recorded_;
  bool has_cut_recording_ = false;
};

}  // namespace scanknit
