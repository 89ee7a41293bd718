#include "app/live/scan_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "app/cli/exit_codes.h"
#include "app/live/tracking_advice.h"
#include "app/scan/frame_count.h"
#include "app/scan/live_scanner.h"
#include "app/scan/stage_timer.h"
#include "app/terminal/view_links.h"
#include "export/mesh/up_rotation.h"
#include "export/picture/depth_picture.h"
#include "view/mesh_chunk.h"

namespace scanknit {
namespace {

using namespace std::chrono_literals;

constexpr auto kLongUpdate = 15ms;  // of the mesh: after a longer one fewer leaves are meshed at a time
constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
constexpr auto kStateEvery = 100ms;
constexpr auto kPictureEvery = 250ms;
constexpr auto kPictureForLater = 2s;  // somebody may come while the scan is paused
constexpr auto kRateWindow = 2s;
constexpr auto kSilence = 2s;  // of a scanner, from which on it is told

/// Moves `cost` towards how long it lived: by half when that is longer, else by a quarter.
class Cost {
 public:
  explicit Cost(std::chrono::steady_clock::duration& cost) : cost_(cost) {}
  ~Cost() {
    const auto more = std::chrono::steady_clock::now() - begin_ - cost_;
    cost_ += more / (more.count() > 0 ? 2 : 4);
  }
  Cost(const Cost&) = delete;
  Cost& operator=(const Cost&) = delete;

 private:
  std::chrono::steady_clock::duration& cost_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

double seconds(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

/// Before anything has come of a frame there is nothing to be seen yet.
ViewPhase phase_in_progress(const RunReport& report) {
  return report.frames.fused + report.frames.lost > 0 ? ViewPhase::kScanning : ViewPhase::kWaiting;
}

std::map<std::string, std::uint64_t> without_zeros(std::map<std::string, std::uint64_t> counts) {
  std::erase_if(counts, [](const auto& count) { return count.second == 0; });
  return counts;
}

std::string why_not(const Result<void>& result) {
  return result ? "" : result.error().text();
}

}  // namespace

ScanView::ScanView(const ViewArguments& arguments, const Job& job, std::string mode, std::stop_token stop,
                   Console& console)
    : arguments_(arguments),
      job_(job),
      mode_(std::move(mode)),
      is_paced_(mode_ == "capture" || job.pace == Pace::kRealtime),
      stop_(std::move(stop)),
      console_(console) {}

Result<void> ScanView::open(UpAxis world_up) {
  if (!arguments_.is_wanted) return {};
  console_.watch_progress(
      [this](std::string_view what, std::size_t done, std::size_t total) { note_work(what, done, total); });
  ViewHello hello;
  hello.title = job_.input.empty() ? "scanner" : job_.input.filename().string();
  hello.mode = mode_;
  hello.up = direction(job_.config.output.world_up.value_or(world_up)).cast<double>();
  hello.is_orbit = arguments_.is_orbit;
  hello.is_paced = is_paced_;
  hello.voxel_size_m = job_.config.fusion.voxel_size_m;
  hello.actions = {ViewAction::kStart, ViewAction::kPause,  ViewAction::kReset,
                   ViewAction::kCrop,  ViewAction::kExport, ViewAction::kFinish};
  auto server = LiveView::start(arguments_.server, hello);
  if (!server) return server.error();
  server_ = *std::move(server);
  server_->refuse_commands("the scan has not begun: the scanner is not ready yet");
  announce(server_->links(), console_);
  publish_state(/*is_urgent=*/true);
  return {};
}

Result<void> ScanView::begin(const TsdfVolume& volume, const RecordingInfo& info) {
  is_other_ = has_ended_;
  if (server_ == nullptr || has_ended_) return {};
  if (auto made = make_mesh(volume); !made) return made;
  server_->refuse_commands("");
  state_.message.clear();
  frame_at_ = Clock::now();
  is_tracked_ = is_tracked(info.poses);
  state_.frames_total = is_paced_ && info.frames == 0 ? 0 : selected_frames(info, job_.config.acquire);
  begun_at_ = Clock::now();
  budget_.go_on(begun_at_);
  return {};
}

void ScanView::show(const Frame& frame, const std::optional<Pose>& T_world_camera, TsdfVolume& volume,
                    RunReport& report) {
  if (server_ == nullptr || has_ended_) return;
  const StageTimer timer(report.stages["view"]);
  const auto begin = Clock::now();
  budget_.earn(begin);
  note(frame, T_world_camera, report);
  is_mesh_behind_ = true;
  state_.memory_mib = static_cast<double>(volume.memory().bytes()) / (1024 * 1024);
  if (budget_.allows(mesh_cost_)) update_some_of_mesh(volume);
  const auto picture_every = server_->clients() > 0 ? kPictureEvery : kPictureForLater;
  if (begin - picture_at_ >= picture_every && budget_.allows(Clock::now() - begin + picture_cost_)) {
    show_picture(frame);
  }
  publish_state(/*is_urgent=*/job_.pace == Pace::kStepped);  // no other frame may come for long
  budget_.spend(Clock::now() - begin);
}

void ScanView::show_picture(const Frame& frame) {
  const Cost cost(picture_cost_);
  picture_at_ = Clock::now();
  server_->publish_picture(picture_message(++pictures_, depth_picture(frame.depth_m)));
}

void ScanView::show_progress(const FrameIntake& intake, TsdfVolume& volume, RunReport& report) {
  if (server_ == nullptr || has_ended_) return;
  note_counts(report);
  if (const auto trouble = intake.trouble()) note_trouble(*trouble);
  if (is_mesh_behind_ && budget_.allows(mesh_cost_)) {
    const StageTimer timer(report.stages["view"]);
    const auto begin = Clock::now();
    update_some_of_mesh(volume);
    budget_.spend(Clock::now() - begin);
  }
  publish_news();
}

void ScanView::note_counts(const RunReport& report) {
  const auto now = Clock::now();
  if (state_.frame != report.frames.read) frame_at_ = now;
  state_.frame = report.frames.read;
  state_.fused = report.frames.fused;
  state_.dropped = report.frames.dropped;
  state_.lost = report.frames.lost;
  if (losses_) state_.losses = without_zeros(named(losses_()));
  while (!fused_at_.empty() && now - fused_at_.front() > kRateWindow) fused_at_.pop_front();
  const double window = std::min(seconds(kRateWindow), seconds(now - begun_at_));
  state_.fps = window > 0 ? static_cast<double>(fused_at_.size()) / window : 0;
  const bool is_silent = mode_ == "capture" && now - frame_at_ >= kSilence;
  state_.silent_s = is_silent ? static_cast<std::size_t>(seconds(now - frame_at_)) : 0;
}

void ScanView::note(const Frame& frame, const std::optional<Pose>& T_world_camera, const RunReport& report) {
  if (T_world_camera) {
    T_world_camera_ = T_world_camera;
    fused_at_.push_back(Clock::now());
  }
  note_counts(report);
  if (state_.phase != ViewPhase::kScanning) state_at_ = {};
  state_.phase = ViewPhase::kScanning;
  note_tracking(report);
  if (!T_world_camera_) return;
  const CameraIntrinsics& camera = frame.intrinsics;
  server_->publish(ViewPose{*T_world_camera_,
                            {0.5 * camera.width / std::abs(camera.fx), 0.5 * camera.height / std::abs(camera.fy)},
                            !T_world_camera.has_value()});
}

/// Of the frame that came last; where poses are given there is nothing to tell of one that could be used.
void ScanView::note_tracking(const RunReport& report) {
  RunReport::TrackedFrame tracked;
  tracked.state = "none";
  if (report.tracking && !report.tracking->frames.empty()) tracked = report.tracking->frames.back();
  if (tracked.state != state_.tracking) state_at_ = {};  // that is news
  state_.tracking = tracked.state;
  state_.reason = tracked.reason;
  state_.advice = tracking_advice(tracked.reason);
}

/// Frames come, and none can be used.
void ScanView::note_trouble(DropReason reason) {
  if (state_.phase != ViewPhase::kScanning) return;
  std::string words = to_string(reason);
  std::replace(words.begin(), words.end(), '_', ' ');
  if (reason == DropReason::kNoDepth) words = "nothing seen";
  state_.tracking = "unusable";
  state_.advice = tracking_advice(words);
  state_.reason = std::move(words);
}

/// Before the first frame and after the last: what is worked on, while it is.
void ScanView::note_work(std::string_view what, std::size_t done, std::size_t total) {
  const bool has_frames = state_.phase != ViewPhase::kExporting && !(state_.phase == ViewPhase::kWaiting && !mesh_);
  if (server_ == nullptr || has_frames) return;
  state_.message = done < total ? fmt::format("{} {} of {}", what, done, total) : "";
  publish_state(/*is_urgent=*/done >= total);
}

void ScanView::publish_state(bool is_urgent) {
  const auto now = Clock::now();
  if (!is_urgent && now - state_at_ < kStateEvery) return;
  state_at_ = now;
  state_.triangles = mesh_ ? mesh_->triangles() : 0;
  state_.is_crop_empty = mesh_ && crop_ && !mesh_->has_triangle_in(*crop_);
  state_.view_share = budget_.share();
  state_.is_behind = is_mesh_behind_;
  server_->publish(state_);
  published_ = state_;
}

void ScanView::publish_news() {
  if (state_ != published_) publish_state(/*is_urgent=*/false);
}

void ScanView::update_mesh(TsdfVolume& volume, std::size_t most_leaves) {
  if (!mesh_) return;  // a reset has failed
  const auto updated = mesh_->update(volume, most_leaves, [&](std::uint32_t chunk, std::string message) {
    server_->publish_chunk(chunk, std::move(message));
  });
  // What cannot be shown is not worth ending a scan for; the mesh of the files tells what is wrong.
  if (!updated) state_.message = updated.error().text();
  is_mesh_behind_ = updated && !mesh_->is_up_to_date();
}

/// As much as takes a moment, on this machine and with these clients.
void ScanView::update_some_of_mesh(TsdfVolume& volume) {
  const auto begin = Clock::now();
  {
    const Cost cost(mesh_cost_);
    update_mesh(volume, leaves_);
  }
  const auto took = Clock::now() - begin;
  if (took > kLongUpdate) {
    leaves_ = std::max(leaves_ / 2, kFewestLeaves);
  } else if (is_mesh_behind_ && 2 * took < kLongUpdate) {
    leaves_ = std::min(leaves_ * 2, kMostLeaves);
  }
}

void ScanView::obey(Reconstruction& scan, FrameIntake& intake, RunReport& report) {
  if (server_ == nullptr || has_ended_) return;
  while (!intake.is_over()) {  // what was asked for after Finish is refused by linger()
    const auto command = server_->next_command(stop_, 0ns);
    if (!command) break;
    obey_one(*command, scan, intake, report);
  }
  if (state_.phase == ViewPhase::kPaused) wait_while_paused(scan, intake, report);
}

void ScanView::wait_while_paused(Reconstruction& scan, FrameIntake& intake, RunReport& report) {
  show_all(scan.volume(), report);
  while (state_.phase == ViewPhase::kPaused && !intake.is_over() && !stop_.stop_requested()) {
    const auto command = server_->next_command(stop_, is_paced_ ? 0ns : 500ms);
    if (command) obey_one(*command, scan, intake, report);
    if (!command && is_paced_) {
      const auto frame = intake.pass_over("paused");
      if (frame && Clock::now() - picture_at_ >= kPictureEvery) show_picture(*frame);
    }
    note_counts(report);
    publish_news();
  }
  budget_.go_on(Clock::now());
}

void ScanView::obey_one(const ViewCommand& command, Reconstruction& scan, FrameIntake& intake, RunReport& report) {
  std::string error;
  switch (command.action) {
    case ViewAction::kStart: state_.phase = phase_in_progress(report); break;
    case ViewAction::kPause: state_.phase = ViewPhase::kPaused; break;
    case ViewAction::kReset: error = why_not(start_over(scan, report)); break;
    case ViewAction::kExport: error = why_not(export_now(scan, report)); break;
    case ViewAction::kFinish: intake.finish(); break;
    case ViewAction::kCrop: crop(command.box, scan); break;
  }
  server_->answer(command, error);
  publish_state(/*is_urgent=*/true);
}

void ScanView::crop(const CropBox& box, Reconstruction& scan) {
  scan.crop(box);
  crop_ = box;
  server_->publish(box);
}

Result<void> ScanView::start_over(Reconstruction& scan, RunReport& report) {
  drop_mesh();
  if (auto begun = scan.start_over(); !begun) return begun;
  if (is_tracked_) crop(std::nullopt, scan);  // another world: the box would be somewhere else
  report.warnings.push_back(fmt::format("begun anew from the live view after frame {}", report.frames.read));
  T_world_camera_.reset();
  state_.tracking = "none";
  state_.reason.clear();
  state_.advice.clear();
  note_counts(report);
  return make_mesh(scan.volume());
}

Result<void> ScanView::make_mesh(const TsdfVolume& volume) {
  auto mesh = LiveMesh::create(volume, job_.config.extract, revision_);
  if (!mesh) return mesh.error();
  mesh_ = *std::move(mesh);
  return {};
}

/// And the trail.
void ScanView::drop_mesh() {
  if (mesh_) revision_ = mesh_->revision() + 1;
  mesh_.reset();
  server_->clear(revision_);
}

Result<void> ScanView::export_now(const Reconstruction& scan, const RunReport& report) {
  const ViewPhase before = state_.phase;
  state_.phase = ViewPhase::kExporting;
  publish_state(/*is_urgent=*/true);
  RunReport of_now = report;
  auto written = scan.write_mesh(of_now, EmptyCrop::kRefused);
  if (written) publish_files(of_now);
  state_.phase = before;
  return written ? Result<void>() : written.error();
}

void ScanView::show_writing() {
  if (server_ == nullptr) return;
  has_ended_ = true;
  state_.phase = ViewPhase::kExporting;
  state_.message.clear();
  server_->refuse_commands("the scan has ended: its mesh is being made");
  publish_state(/*is_urgent=*/true);
}

void ScanView::show_result(Reconstruction& scan, const FrameIntake& intake, RunReport& report) {
  if (server_ == nullptr) return;
  if (is_other_) return show_anew(scan, intake, report);
  show_all(scan.volume(), report);
}

void ScanView::show_all(TsdfVolume& volume, RunReport& report) {
  const StageTimer timer(report.stages["view_all"]);
  update_mesh(volume, kAll);
  publish_state(/*is_urgent=*/true);
}

void ScanView::show_anew(Reconstruction& scan, const FrameIntake& intake, RunReport& report) {
  if (server_ == nullptr) return;
  state_.message.clear();
  drop_mesh();
  std::vector<Eigen::Vector3d> trail;
  for (const StampedPose& pose : intake.trajectory()) trail.push_back(pose.T_world_camera.translation());
  server_->publish_trail(trail);
  if (!scan.crop()) crop(std::nullopt, scan);
  if (const auto made = make_mesh(scan.volume()); !made) return console_.warn(made.error().text());
  show_all(scan.volume(), report);
}

void ScanView::publish_files(const RunReport& report) {
  std::vector<std::filesystem::path> files;
  for (const auto& [kind, path] : report.files) {
    if (kind == "glb" || kind == "stl" || kind == "ply" || kind == "obj") files.emplace_back(path);
  }
  server_->publish_files(files);
}

void ScanView::linger(const RunReport& report) {
  if (server_ == nullptr) return;
  constexpr const char* kOver = "the scan is over";
  server_->refuse_commands(kOver);
  const bool is_well = report.exit_code == kExitOk || report.exit_code == kExitInterrupted;
  state_.phase = is_well ? ViewPhase::kFinished : ViewPhase::kFailed;
  state_.message = report.exit_code == kExitOk ? "" : report.status;
  const auto& warnings = report.warnings;
  for (const char* of_crop : {kCropIgnored, kCropGone}) {
    const bool is_told = std::find(warnings.begin(), warnings.end(), of_crop) != warnings.end();
    if (state_.message.empty() && is_told) state_.message = of_crop;
  }
  note_counts(report);
  if (report.losses) state_.losses = without_zeros(*report.losses);
  publish_files(report);
  publish_state(/*is_urgent=*/true);
  if (stop_.stop_requested() || report.frames.fused == 0) return;
  console_.info("the live view stays open until Ctrl-C");
  while (!stop_.stop_requested()) {
    if (const auto command = server_->next_command(stop_, 1s)) server_->answer(*command, kOver);
  }
}

}  // namespace scanknit
