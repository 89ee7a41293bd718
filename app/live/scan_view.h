// ScanView: a scan's live view, served between two frames in a small share of their time.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

#include "acquire/frame_source.h"
#include "acquire/raw_frame.h"
#include "app/commands/commands.h"
#include "app/live/live_mesh.h"
#include "app/live/view_budget.h"
#include "app/scan/frame_intake.h"
#include "app/scan/pipeline.h"
#include "app/scan/reconstruction.h"
#include "app/terminal/console.h"
#include "view/live_view.h"

namespace scanknit {

class ScanView {
 public:
  /// All references outlive it. Unless a view is wanted, nothing happens in any of the functions. `mode`: "run" or
  /// "capture".
  ScanView(const ViewArguments& arguments, const Job& job, std::string mode, std::stop_token stop, Console& console);
  ~ScanView() { console_.watch_progress(nullptr); }
  ScanView(const ScanView&) = delete;
  ScanView& operator=(const ScanView&) = delete;

  /// Listens, and says where on the console. Until begin(), commands are refused. Errors: LiveView::start().
  [[nodiscard]] Result<void> open(UpAxis world_up);

  /// `volume`, empty still, is what grows from now on; it keeps its address. Once a scan has ended, others of the same
  /// frames are not watched: their results are shown. Errors: IncrementalMesher::create().
  [[nodiscard]] Result<void> begin(const TsdfVolume& volume, const RecordingInfo& info);

  /// Asked while frames are taken, until told otherwise by nothing: pictures that the scanner sent in vain.
  void watch_losses(std::function<LossCounters()> losses) { losses_ = std::move(losses); }

  /// What became of a frame; without a pose it was left out. A twentieth of the time of the scan goes into it
  /// (view_budget.h): stage "view" of the report.
  void show(const Frame& frame, const std::optional<Pose>& T_world_camera, TsdfVolume& volume, RunReport& report);

  /// No frame could be used, or none has come for a moment: the page is told what is different, and some more of the
  /// mesh is shown.
  void show_progress(const FrameIntake& intake, TsdfVolume& volume, RunReport& report);

  /// Does what was asked for since the last time, and waits while the scan is paused (a scanner's frames pass by).
  void obey(Reconstruction& scan, FrameIntake& intake, RunReport& report);

  /// No more frames that could be watched or steered: the files are being written, the frames perhaps fused again,
  /// whose progress is told. Commands are refused.
  void show_writing();

  /// The scan is over: the whole mesh, however long it takes; stage "view_all" of the report.
  void show_result(Reconstruction& scan, const FrameIntake& intake, RunReport& report);

  /// Outside of it nothing is to be meshed.
  [[nodiscard]] const CropBox& crop_in_force() const { return crop_; }

  /// The frames have been fused again: the whole mesh and the trail, in place of those that were shown.
  void show_anew(Reconstruction& scan, const FrameIntake& intake, RunReport& report);

  /// How it ended, and what can be downloaded. Then serves the page until stopped; returns at once if that was asked
  /// for already, or if nothing has been fused.
  void linger(const RunReport& report);

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kFewestLeaves = 16, kMostLeaves = 256;      ///< meshed between two frames
  static constexpr Clock::duration kGuess = std::chrono::milliseconds(5);  ///< what the first update may take

  void note(const Frame& frame, const std::optional<Pose>& T_world_camera, const RunReport& report);
  void note_counts(const RunReport& report);
  void note_trouble(DropReason reason);
  void note_tracking(const RunReport& report);
  void note_work(std::string_view what, std::size_t done, std::size_t total);
  void show_picture(const Frame& frame);
  void publish_state(bool is_urgent);
  void publish_news();
  void crop(const CropBox& box, Reconstruction& scan);
  [[nodiscard]] Result<void> make_mesh(const TsdfVolume& volume);
  void drop_mesh();
  void show_all(TsdfVolume& volume, RunReport& report);
  void update_mesh(TsdfVolume& volume, std::size_t most_leaves);
  void update_some_of_mesh(TsdfVolume& volume);
  void wait_while_paused(Reconstruction& scan, FrameIntake& intake, RunReport& report);
  void obey_one(const ViewCommand& command, Reconstruction& scan, FrameIntake& intake, RunReport& report);
  [[nodiscard]] Result<void> start_over(Reconstruction& scan, RunReport& report);
  [[nodiscard]] Result<void> export_now(const Reconstruction& scan, const RunReport& report);
  void publish_files(const RunReport& report);

  const ViewArguments& arguments_;
  const Job& job_;
  std::string mode_;
  bool is_paced_;            ///< frames come whether they are taken or not
  bool is_tracked_ = false;  ///< poses are not given
  bool has_ended_ = false;   ///< the scan that was watched
  bool is_other_ = false;    ///< the scan since begin() is not the one whose mesh is shown
  std::stop_token stop_;
  Console& console_;
  std::unique_ptr<LiveView> server_;  ///< null: not wanted, or not open yet
  std::optional<LiveMesh> mesh_;
  CropBox crop_;                 ///< in force
  std::uint32_t revision_ = 0;   ///< of the mesh that was shown before
  bool is_mesh_behind_ = false;  ///< the volume may have what it does not show
  ViewState state_, published_;
  std::function<LossCounters()> losses_;
  std::optional<Pose> T_world_camera_;  ///< of the last frame that had one
  std::deque<Clock::time_point> fused_at_;
  Clock::time_point begun_at_ = Clock::now(), frame_at_ = begun_at_, state_at_{}, picture_at_{};
  ViewBudget budget_;
  Clock::duration mesh_cost_ = kGuess, picture_cost_ = kGuess;  ///< of late
  std::size_t leaves_ = kFewestLeaves;                          ///< of an update of the mesh: as many as take a moment
  std::uint32_t pictures_ = 0;
};

}  // namespace scanknit
