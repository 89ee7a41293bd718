// FrameIntake: usable frames one by one, with everything that happens on the way counted in the report.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "acquire/frame_source.h"
#include "app/scan/sequence_ranges.h"
#include "app/terminal/console.h"
#include "core/frame.h"
#include "core/result.h"
#include "export/report/report.h"

namespace scanknit {

class FrameIntake {
 public:
  /// All references outlive it.
  FrameIntake(FrameSource& source, const AcquireConfig& config, std::stop_token stop, Console& console,
              RunReport& report);

  /// The next frame that has depth and a pose, or is to be tracked. Nothing when it had to be dropped, which is
  /// counted; when none has come for a twentieth of a second; and when it is over.
  [[nodiscard]] std::optional<Frame> next();

  /// No more frames: the source has ended or failed, was stopped, or finish() was called.
  [[nodiscard]] bool is_over() const { return is_over_; }

  [[nodiscard]] const std::stop_token& stop() const { return stop_; }

  /// Why the last frames could not be used, when there were a few in a row.
  [[nodiscard]] std::optional<DropReason> trouble() const;

  /// Somebody wants no more frames.
  void finish();

  void note_fused(const Frame& frame, const Pose& T_world_camera, bool is_budget_reached);

  /// The volume would not have the frame because of its pose: counted as dropped.
  void note_refused(const Frame& frame, const Error& error);

  /// The next frame, usable or not, is left out, counted as dropped for `reason`, one word. It is given to be looked at
  /// if it has pictures.
  std::optional<Frame> pass_over(const char* reason);

  /// What was fused, or lost, counts as dropped ("reset"); the trajectory is empty.
  void start_over();

  /// The frames that came, usable or not, but for those that were passed over or came before start_over().
  [[nodiscard]] const SequenceRanges& taken() const { return taken_; }
  /// The counts of the others.
  [[nodiscard]] const RunReport::Frames& left_out() const { return left_out_; }

  [[nodiscard]] const RecordingInfo& info() const { return source_.info(); }

  /// Other poses for the frames that were fused, in their order.
  void correct(const std::vector<Pose>& T_world_cameras);

  /// After the last frame: what was dropped is said on the console. Errors: the source's own; kInput when not one frame
  /// was fused.
  [[nodiscard]] Result<void> result();

  [[nodiscard]] const std::vector<StampedPose>& trajectory() const { return trajectory_; }
  /// Frame::sequence of each pose of the trajectory.
  [[nodiscard]] const std::vector<std::uint64_t>& fused_sequences() const { return fused_sequences_; }

  /// The frames were fused again, not all of them, or more; the others count as lost.
  void replace_trajectory(std::vector<StampedPose> trajectory, std::vector<std::uint64_t> sequences);

 private:
  using Event = std::variant<Frame, FrameDropped>;
  [[nodiscard]] std::optional<FrameEvent> wait_for_event();
  [[nodiscard]] std::optional<Event> next_event();
  void note_dropped(const FrameDropped& dropped);
  void leave_out(const std::string& reason);
  void say_dropped();

  FrameSource& source_;
  const AcquireConfig& config_;
  std::stop_token stop_;
  Console& console_;
  RunReport& report_;
  std::size_t expected_ = 0;
  std::chrono::steady_clock::duration waited_{};  ///< for the next frame, so far
  std::size_t unusable_ = 0;                      ///< frames in a row
  DropReason last_drop_ = DropReason::kUnreadable;
  bool is_over_ = false, is_finished_ = false;
  std::optional<Error> error_;
  std::vector<StampedPose> trajectory_;
  std::vector<std::uint64_t> fused_sequences_;
  SequenceRanges taken_;
  std::uint64_t newest_ = 0;      ///< sequence number that has come
  std::uint64_t taken_from_ = 0;  ///< since frames were left out
  RunReport::Frames left_out_;
};

}  // namespace scanknit
