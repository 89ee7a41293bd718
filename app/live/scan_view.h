// ScanView: the live view of a scan; works between two frames and takes a small share of their time.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "app/commands.h"
#include "app/live/live_mesh.h"
#include "app/live/tracking_watch.h"
#include "app/live/view_budget.h"
#include "app/report/run.h"
#include "app/terminal/console.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "view/live_view.h"

namespace scanknit {

/// Shows a scan on the page, takes the commands of its viewers, and passes messages, warnings and progress on to the
/// console. Without --view it only does the latter.
class ScanView final : public ScanObserver {
 public:
  enum class Mode { kRun, kCapture };

  /// All references outlive it. `stop` ends serve_result().
  ScanView(const ViewArguments& arguments, const ScanJob& job, Mode mode, std::stop_token stop, Console& console);

  void on_message(LogLevel level, std::string_view text) override { console_.say(level, text); }
  void on_warning(const ScanWarning& warning) override { console_.warn(warning.text); }
  void on_progress(std::string_view what, std::size_t done, std::size_t total) override;

  /// Starts the server and prints its links on the console. Refuses commands until on_begin(). Errors: those of
  /// LiveView::start().
  [[nodiscard]] Result<void> on_open(const RecordingInfo& info) override;
  /// Shows the volume while it grows. In a second pass, after the frames have ended, shows only the result. Errors:
  /// those of IncrementalMesher::create().
  [[nodiscard]] Result<void> on_begin(const ScanState& scan) override;
  /// Spends at most a twentieth of the scan's time on the view (view_budget.h).
  void on_frame(const Frame& frame, const std::optional<Pose>& T_world_camera, const ScanState& scan) override;
  void on_no_frame(const Frame* skipped, const ScanState& scan) override;
  void on_phase(const ScanState& scan) override;
  /// Shows the whole mesh, however long it takes.
  void on_tracked_mesh(const ScanState& scan) override;
  /// Replaces mesh and trail on the page by the whole refined ones.
  void on_refined(const ScanState& scan) override;
  [[nodiscard]] bool needs_volume_after_mesh() const override { return server_ != nullptr; }
  [[nodiscard]] std::optional<ScanCommand> next_command(std::stop_token stop,
                                                        std::chrono::nanoseconds patience) override;
  void on_answer(const ScanCommand& command, const Result<void>& outcome, const FilesByKind& files,
                 const ScanState& scan) override;

  /// Time spent on the view: stages "view" and "view_all".
  [[nodiscard]] const StageTimesByName& times() const { return times_; }

  /// Shows how the scan ended, and which files can be downloaded. Then serves the page until stopped; returns at once
  /// if the stop was requested already, or if nothing has been fused.
  void serve_result(const CommandRun& run);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kFewestLeaves = 16, kMostLeaves = 256;      ///< leaves meshed between two frames
  static constexpr Clock::duration kGuess = std::chrono::milliseconds(5);  ///< first estimate of an update's duration

  [[nodiscard]] bool shows_frames() const { return server_ != nullptr && !has_ended_; }
  void note_pose(const Frame& frame, const std::optional<Pose>& T_world_camera);
  void note_counts(const ScanState& scan);
  void note_counts(const FrameCounts& frames, const std::optional<LossCounters>& losses);
  void note_trouble(DropReason reason);
  void note_tracking(const TrackedFrame* newest);
  void note_caution(const Frame& frame, const std::optional<Pose>& T_world_camera, const TrackedFrame* newest);
  void show_picture(const Frame& frame);
  void publish_state(bool is_urgent);
  void publish_news();
  void publish_crop(const CropBox& box);
  void publish_files(const FilesByKind& files);
  [[nodiscard]] Result<void> make_mesh(const TsdfVolume& volume);
  void drop_mesh();
  void show_all(TsdfVolume& volume);
  void update_mesh(TsdfVolume& volume, std::size_t most_leaves);
  void update_some_of_mesh(TsdfVolume& volume);

  const ViewArguments& arguments_;
  const ScanJob& job_;
  Mode mode_;
  bool is_paced_;  ///< frames come at their own pace
  bool has_begun_ = false;
  bool has_ended_ = false;       ///< the frames of the first pass have ended
  bool is_second_pass_ = false;  ///< the page still shows the mesh of the first pass
  std::stop_token stop_;
  Console& console_;
  std::unique_ptr<LiveView> server_;  ///< null: no view is wanted, or on_open() was not called yet
  std::optional<LiveMesh> mesh_;
  CropBox crop_;                        ///< the crop box in force
  std::optional<ViewCommand> command_;  ///< the command that is being carried out
  std::uint32_t revision_ = 0;          ///< first revision of the next mesh
  bool is_mesh_behind_ = false;         ///< the volume may have changes that the mesh does not show
  ViewState state_, published_;
  std::optional<Pose> T_world_camera_;  ///< pose of the last frame that had one
  TrackingWatch watch_;
  std::deque<Clock::time_point> fused_at_;
  Clock::time_point begun_at_ = Clock::now(), frame_at_ = begun_at_, state_at_{}, picture_at_{};
  ViewBudget budget_;
  Clock::duration mesh_cost_ = kGuess, picture_cost_ = kGuess;  ///< recent durations
  std::size_t leaves_ = kFewestLeaves;                          ///< leaves of the next update of the mesh
  std::uint32_t pictures_ = 0;
  StageTimesByName times_;
};

}  // namespace scanknit
