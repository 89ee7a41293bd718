// ScanView: a scan's live view, served between two frames in a small share of their time.
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

#include "app/commands/commands.h"
#include "app/live/live_mesh.h"
#include "app/live/view_budget.h"
#include "app/report/run.h"
#include "app/terminal/console.h"
#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "view/live_view.h"

namespace scanknit {

/// Shows a scan on the page and takes the commands of those who look on; all that it is told goes to the console as
/// well. Unless a view is wanted it does that alone.
class ScanView final : public ScanObserver {
 public:
  enum class Mode { kRun, kCapture };

  /// All references outlive it. `stop`: the page is served no longer.
  ScanView(const ViewArguments& arguments, const ScanJob& job, Mode mode, std::stop_token stop, Console& console);

  void on_message(LogLevel level, std::string_view text) override { console_.say(level, text); }
  void on_warning(const ScanWarning& warning) override { console_.warn(warning.text); }
  void on_progress(std::string_view what, std::size_t done, std::size_t total) override;

  /// Listens, and says where on the console. Until on_begin(), commands are refused. Errors: LiveView::start().
  [[nodiscard]] Result<void> on_open(const RecordingInfo& info) override;
  /// Shows the volume as it grows. Once the frames of a scan are over, those of a second pass are not shown, only what
  /// comes of them. Errors: IncrementalMesher::create().
  [[nodiscard]] Result<void> on_begin(const ScanState& scan) override;
  /// A twentieth of the time of the scan goes into the view (view_budget.h).
  void on_frame(const Frame& frame, const std::optional<Pose>& T_world_camera, const ScanState& scan) override;
  void on_no_frame(const Frame* passed_by, const ScanState& scan) override;
  void on_phase(const ScanState& scan) override;
  /// Shows the whole mesh, however long it takes.
  void on_tracked_mesh(const ScanState& scan) override;
  /// Shows the whole mesh and the trail in place of those that were shown.
  void on_refined(const ScanState& scan) override;
  [[nodiscard]] std::optional<ScanCommand> next_command(std::stop_token stop,
                                                        std::chrono::nanoseconds patience) override;
  void on_answer(const ScanCommand& command, const Result<void>& outcome, const FilesByKind& files,
                 const ScanState& scan) override;

  /// Time spent on the view: stages "view" and "view_all".
  [[nodiscard]] const StageTimesByName& times() const { return times_; }

  /// Tells how the scan ended, and what can be downloaded. Then serves the page until stopped; returns at once if that
  /// was asked for already, or if nothing has been fused.
  void serve_result(const CommandRun& run);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kFewestLeaves = 16, kMostLeaves = 256;      ///< meshed between two frames
  static constexpr Clock::duration kGuess = std::chrono::milliseconds(5);  ///< what the first update may take

  [[nodiscard]] bool shows_frames() const { return server_ != nullptr && !has_ended_; }
  void note_pose(const Frame& frame, const std::optional<Pose>& T_world_camera);
  void note_counts(const ScanState& scan);
  void note_counts(const FrameCounts& frames, const std::optional<LossCounters>& losses);
  void note_trouble(DropReason reason);
  void note_tracking(const TrackedFrame* newest);
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
  bool is_paced_;  ///< frames come whether they are taken or not
  bool has_begun_ = false;
  bool has_ended_ = false;       ///< the frames that were shown are over
  bool is_second_pass_ = false;  ///< the scan since on_begin() is not the one whose mesh is shown
  std::stop_token stop_;
  Console& console_;
  std::unique_ptr<LiveView> server_;  ///< null: not wanted, or not open yet
  std::optional<LiveMesh> mesh_;
  CropBox crop_;                        ///< in force
  std::optional<ViewCommand> command_;  ///< is being carried out
  std::uint32_t revision_ = 0;          ///< of the mesh that was shown before
  bool is_mesh_behind_ = false;         ///< the volume may have what it does not show
  ViewState state_, published_;
  std::optional<Pose> T_world_camera_;  ///< of the last frame that had one
  std::deque<Clock::time_point> fused_at_;
  Clock::time_point begun_at_ = Clock::now(), frame_at_ = begun_at_, state_at_{}, picture_at_{};
  ViewBudget budget_;
  Clock::duration mesh_cost_ = kGuess, picture_cost_ = kGuess;  ///< of late
  std::size_t leaves_ = kFewestLeaves;                          ///< of an update of the mesh: as many as take a moment
  std::uint32_t pictures_ = 0;
  StageTimesByName times_;
};

}  // namespace scanknit
