// TurntableScan: a recording of a turntable, from what stands still to the mesh that closes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "app/scan/frame_intake.h"
#include "app/scan/known_angles.h"
#include "app/scan/pipeline.h"
#include "app/scan/reconstruction.h"
#include "core/result.h"
#include "fusion/turntable/look_through.h"
#include "fusion/turntable/picture_part.h"
#include "fusion/turntable/still_scene.h"
#include "fusion/turntable/turntable_pairs.h"
#include "fusion/turntable/turntable_prior.h"
#include "fusion/turntable/turntable_space.h"

namespace scanknit {

class CutRecording;

class TurntableScan {
 public:
  /// `job.input` is the recording, which is read several times. `poses`: kRecording, its poses are exact and only the
  /// cut is made; else they are tracked. All references outlive it.
  TurntableScan(const Job& job, PoseMode poses, std::stop_token stop, Console& console, RunReport& report);

  /// Learns from some fifty of the recording's frames what stands still. Errors: the recording's.
  [[nodiscard]] Result<void> learn();

  /// True when something does, and poses are tracked: clear_still() changes frames.
  [[nodiscard]] bool changes_frames() const { return !has_poses_ && !still_.empty(); }

  /// For tracking: takes out of a filtered frame what stands still, and keeps the part of the picture where something
  /// moves. Nothing is done where poses are known.
  void clear_still(Frame& frame) const;

  /// After the frames were tracked: finds the axis and all angles, fuses the frames again, cuts the volume, and gives
  /// it to `scan` and the poses to `intake`. The world's origin is then where the axis meets the disc, its -y is up
  /// (poses of the recording stay as they are). False: it is no turntable, for the reason that the report has; `scan`
  /// and `intake` are as they were. Errors: the recording's; what ends a scan.
  [[nodiscard]] Result<bool> refine(Reconstruction& scan, FrameIntake& intake);

  /// Tells why not, where it did not come to refine().
  void conclude(bool has_mesh);

 private:
  /// Every frame that was read while tracking.
  struct Nodes {
    std::vector<std::uint64_t> sequences;
    std::vector<double> stamps;
    std::vector<std::int64_t> times_ns;  ///< 0 without a clock
    std::vector<bool> is_tracked;        ///< the others have what angles_of_all() says
    TurntableMotion motion;
    std::vector<Pose> T_world_camera;  ///< of the recording, if they are known
    [[nodiscard]] std::optional<std::size_t> find(std::uint64_t sequence) const;
  };
  using Visit = std::function<void(Frame&)>;

  [[nodiscard]] Result<void> read_frames(std::size_t every, const Visit& visit) const;
  [[nodiscard]] std::vector<DepthImage> moving_parts() const;
  [[nodiscard]] bool begin_nodes(const FrameIntake& intake);
  [[nodiscard]] bool find_room();
  [[nodiscard]] Result<bool> find_motion(std::set<std::size_t>& held);
  [[nodiscard]] Result<bool> find_pairs(TurntablePairs& pairs);
  [[nodiscard]] Result<void> measure_pairs(TurntablePairs& pairs);
  [[nodiscard]] Result<void> check_known_angles(const RecordingInfo& info);
  [[nodiscard]] std::optional<AnglePrior> agreed(AnglePrior prior, const TurntableSolution& seen,
                                                 const std::vector<std::size_t>& parts);
  void join_by_angles(std::vector<std::size_t>& parts);
  void warn_of_left_out(const std::set<std::size_t>& held);
  void warn(const std::string& text);
  [[nodiscard]] bool accept(const TurntableSolution& solution, const TurntablePairs& pairs);
  [[nodiscard]] Result<bool> fuse(const std::set<std::size_t>& held, Reconstruction& scan, FrameIntake& intake);
  void add_witnesses();
  void prepare_for_fusion(Frame& frame, double angle_rad, std::size_t& removed) const;
  [[nodiscard]] Result<void> keep_cut(const Frame& frame, const Pose& T_world_camera, CutRecording& kept) const;
  [[nodiscard]] bool give_up(const char* reason);

  const Job& job_;
  bool has_poses_;
  std::stop_token stop_;
  Console& console_;
  RunReport& report_;
  RunReport::Turntable& told_;
  KnownAngles known_;
  CameraIntrinsics camera_;
  std::vector<DepthImage> samples_;
  std::vector<std::uint64_t> sample_sequences_;
  StillScene still_;
  std::optional<PixelRect> moving_rect_;  ///< nothing: the whole picture
  double depth_m_ = 1;                    ///< typical, of what moves
  Nodes nodes_;
  std::optional<TurntableSpace> space_;
  std::optional<PixelRect> space_rect_;
  std::optional<LookThrough> look_through_;
};

}  // namespace scanknit
