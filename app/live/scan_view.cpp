#include "app/live/scan_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "acquire/live/loss_names.h"
#include "app/exit_codes.h"
#include "app/live/tracking_advice.h"
#include "app/terminal/view_links.h"
#include "export/mesh/up_rotation.h"
#include "export/picture/depth_picture.h"
#include "scan/frames/frame_count.h"
#include "scan/stage_times.h"
#include "view/mesh_chunk.h"

namespace scanknit {
namespace {

using namespace std::chrono_literals;

constexpr auto kLongUpdate = 15ms;  // after a longer update of the mesh, the next one has fewer leaves
constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
constexpr auto kStateEvery = 100ms;
constexpr auto kPictureEvery = 250ms;
constexpr auto kPictureForLater = 2s;  // without viewers: for one that joins during a pause
constexpr auto kRateWindow = 2s;
constexpr auto kSilence = 2s;  // a scanner that is silent for longer is reported

/// Updates the estimate `cost` by the lifetime of this object: moves it half the way up, or a quarter of the way down.
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

std::map<std::string, std::uint64_t> without_zeros(std::map<std::string, std::uint64_t> counts) {
  std::erase_if(counts, [](const auto& count) { return count.second == 0; });
  return counts;
}

ViewPhase view_phase(ScanPhase phase) {
  switch (phase) {
    case ScanPhase::kWaiting: return ViewPhase::kWaiting;
    case ScanPhase::kScanning: return ViewPhase::kScanning;
    case ScanPhase::kPaused: return ViewPhase::kPaused;
    case ScanPhase::kExporting:
    case ScanPhase::kWriting: return ViewPhase::kExporting;
  }
  return ViewPhase::kWaiting;
}

ScanCommand::Kind kind_of(ViewAction action) {
  switch (action) {
    case ViewAction::kStart: return ScanCommand::Kind::kStart;
    case ViewAction::kPause: return ScanCommand::Kind::kPause;
    case ViewAction::kReset: return ScanCommand::Kind::kReset;
    case ViewAction::kCrop: return ScanCommand::Kind::kCrop;
    case ViewAction::kExport: return ScanCommand::Kind::kExport;
    case ViewAction::kFinish: return ScanCommand::Kind::kFinish;
  }
  return ScanCommand::Kind::kStart;
}

}  // namespace

ScanView::ScanView(const ViewArguments& arguments, const ScanJob& job, Mode mode, std::stop_token stop,
                   Console& console)
    : arguments_(arguments),
      job_(job),
      mode_(mode),
      is_paced_(mode == Mode::kCapture || job.pace == Pace::kRealtime),
      stop_(std::move(stop)),
      console_(console) {}

Result<void> ScanView::on_open(const RecordingInfo& info) {
  if (!arguments_.is_wanted) return {};
  ViewHello hello;
  hello.title = job_.input.empty() ? "scanner" : job_.input.filename().string();
  hello.mode = mode_ == Mode::kCapture ? "capture" : "run";
  hello.up = direction(job_.config.output.world_up.value_or(info.world_up)).cast<double>();
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

Result<void> ScanView::on_begin(const ScanState& scan) {
  is_second_pass_ = has_ended_;
  const bool is_first = !std::exchange(has_begun_, true);
  if (is_first && mode_ == Mode::kCapture) {
    console_.info("Ctrl-C ends the scan and makes the mesh; a second one leaves at once");
  }
  if (!shows_frames()) return {};
  if (!is_first) {  // called after a reset
    drop_mesh();
    publish_crop(scan.crop);
    T_world_camera_.reset();
    note_tracking(nullptr);
    note_counts(scan);
    return make_mesh(scan.volume);
  }
  if (auto made = make_mesh(scan.volume); !made) return made;
  server_->refuse_commands("");
  state_.message.clear();
  frame_at_ = Clock::now();
  state_.frames_total = is_paced_ && scan.info.frames == 0 ? 0 : selected_frames(scan.info, job_.config.acquire);
  begun_at_ = Clock::now();
  budget_.go_on(begun_at_);
  return {};
}

void ScanView::on_frame(const Frame& frame, const std::optional<Pose>& T_world_camera, const ScanState& scan) {
  if (!shows_frames()) return;
  const StageTimer timer(times_["view"]);
  const auto begin = Clock::now();
  budget_.earn(begin);
  if (T_world_camera) fused_at_.push_back(begin);
  note_counts(scan);
  if (state_.phase != ViewPhase::kScanning) state_at_ = {};  // publishes the change at once
  state_.phase = ViewPhase::kScanning;
  note_tracking(scan.newest);
  note_caution(frame, T_world_camera, scan.newest);
  note_pose(frame, T_world_camera);
  is_mesh_behind_ = true;
  state_.memory_mib = static_cast<double>(scan.volume.memory_bytes()) / (1024 * 1024);
  if (budget_.allows(mesh_cost_)) update_some_of_mesh(scan.volume);
  const auto picture_every = server_->clients() > 0 ? kPictureEvery : kPictureForLater;
  if (begin - picture_at_ >= picture_every && budget_.allows(Clock::now() - begin + picture_cost_)) {
    show_picture(frame);
  }
  publish_state(/*is_urgent=*/job_.pace == Pace::kStepped);  // the next frame may come much later
  budget_.spend(Clock::now() - begin);
}

void ScanView::show_picture(const Frame& frame) {
  const Cost cost(picture_cost_);
  picture_at_ = Clock::now();
  server_->publish_picture(picture_message(++pictures_, depth_picture(frame.depth_m)));
}

void ScanView::on_no_frame(const Frame* skipped, const ScanState& scan) {
  if (!shows_frames()) return;
  note_counts(scan);
  if (scan.phase == ScanPhase::kPaused) {
    if (skipped != nullptr && Clock::now() - picture_at_ >= kPictureEvery) show_picture(*skipped);
    budget_.go_on(Clock::now());
    return publish_news();
  }
  if (scan.trouble) note_trouble(*scan.trouble);
  if (is_mesh_behind_ && budget_.allows(mesh_cost_)) {
    const StageTimer timer(times_["view"]);
    const auto begin = Clock::now();
    update_some_of_mesh(scan.volume);
    budget_.spend(Clock::now() - begin);
  }
  publish_news();
}

void ScanView::note_counts(const ScanState& scan) {
  note_counts(scan.frames, scan.losses);
}

void ScanView::note_counts(const FrameCounts& frames, const std::optional<LossCounters>& losses) {
  const auto now = Clock::now();
  if (state_.frame != frames.read) frame_at_ = now;
  state_.frame = frames.read;
  state_.fused = frames.fused;
  state_.dropped = frames.dropped;
  state_.lost = frames.lost;
  if (losses) state_.losses = without_zeros(losses_by_name(*losses));
  while (!fused_at_.empty() && now - fused_at_.front() > kRateWindow) fused_at_.pop_front();
  const double window = std::min(seconds(kRateWindow), seconds(now - begun_at_));
  state_.fps = window > 0 ? static_cast<double>(fused_at_.size()) / window : 0;
  const bool is_silent = mode_ == Mode::kCapture && now - frame_at_ >= kSilence;
  state_.silent_s = is_silent ? static_cast<std::size_t>(seconds(now - frame_at_)) : 0;
}

void ScanView::note_pose(const Frame& frame, const std::optional<Pose>& T_world_camera) {
  if (T_world_camera) T_world_camera_ = T_world_camera;
  if (!T_world_camera_) return;
  const CameraIntrinsics& camera = frame.intrinsics;
  server_->publish(ViewPose{*T_world_camera_,
                            {0.5 * camera.width / std::abs(camera.fx), 0.5 * camera.height / std::abs(camera.fy)},
                            !T_world_camera.has_value()});
}

/// Shows how the last frame was tracked. When poses are given, a usable frame has no such state.
void ScanView::note_tracking(const TrackedFrame* newest) {
  const std::string tracking = newest == nullptr ? "none" : to_string(newest->state);
  if (tracking != state_.tracking) state_at_ = {};  // publishes the change at once
  state_.tracking = tracking;
  const TrackReason reason = newest == nullptr ? TrackReason::kNone : newest->reason;
  state_.reason = to_string(reason);
  state_.advice = tracking_advice(reason);
}

/// Shows a well tracked camera as weak when it will soon be lost.
void ScanView::note_caution(const Frame& frame, const std::optional<Pose>& T_world_camera, const TrackedFrame* newest) {
  if (newest == nullptr || !T_world_camera) return watch_.reset();
  const auto caution = watch_.look(frame, *T_world_camera, newest->points);
  if (!caution || newest->state != TrackState::kOk) return;
  state_.tracking = to_string(TrackState::kWeak);
  state_.reason = caution->reason;
  state_.advice = caution->advice;
}

/// Shows that frames come but cannot be used.
void ScanView::note_trouble(DropReason reason) {
  if (state_.phase != ViewPhase::kScanning) return;
  const TrackReason seen = reason == DropReason::kNoDepth ? TrackReason::kNothingSeen : TrackReason::kNone;
  state_.tracking = "unusable";
  state_.advice = tracking_advice(seen);
  state_.reason = seen == TrackReason::kNone ? to_string(reason) : to_string(seen);
  std::replace(state_.reason.begin(), state_.reason.end(), '_', ' ');
}

/// Shows progress on the page only before the first frame and after the last one.
void ScanView::on_progress(std::string_view what, std::size_t done, std::size_t total) {
  console_.progress(what, done, total);
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
  if (!mesh_) return;  // no mesh: a reset has failed
  const auto updated = mesh_->update(volume, most_leaves, [&](std::uint32_t chunk, std::string message) {
    server_->publish_chunk(chunk, std::move(message));
  });
  // An error of the live mesh does not end the scan; writing the mesh files will report its cause.
  if (!updated) state_.message = updated.error().text();
  is_mesh_behind_ = updated && !mesh_->is_up_to_date();
}

/// Meshes as many leaves as take about kLongUpdate.
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

std::optional<ScanCommand> ScanView::next_command(std::stop_token stop, std::chrono::nanoseconds patience) {
  if (!shows_frames()) return std::nullopt;
  command_ = server_->next_command(std::move(stop), patience);
  if (!command_) return std::nullopt;
  return ScanCommand{kind_of(command_->action), command_->box};
}

void ScanView::on_answer(const ScanCommand& command, const Result<void>& outcome, const FilesByKind& files,
                         const ScanState& scan) {
  if (!command_) return;
  if (state_.phase == ViewPhase::kPaused) budget_.go_on(Clock::now());
  state_.phase = view_phase(scan.phase);
  if (command.kind == ScanCommand::Kind::kCrop) publish_crop(scan.crop);
  if (!files.empty()) publish_files(files);
  server_->answer(*command_, outcome ? "" : outcome.error().text());
  publish_state(/*is_urgent=*/true);
}

void ScanView::on_phase(const ScanState& scan) {
  if (!shows_frames()) return;
  state_.phase = view_phase(scan.phase);
  if (scan.phase == ScanPhase::kPaused) return show_all(scan.volume);
  if (scan.phase == ScanPhase::kWriting) {
    has_ended_ = true;
    state_.message.clear();
    server_->refuse_commands("the scan has ended: its mesh is being made");
  }
  publish_state(/*is_urgent=*/true);
}

void ScanView::publish_crop(const CropBox& box) {
  crop_ = box;
  server_->publish(box);
}

Result<void> ScanView::make_mesh(const TsdfVolume& volume) {
  auto mesh = LiveMesh::create(volume, job_.config.extract, revision_);
  if (!mesh) return mesh.error();
  mesh_ = *std::move(mesh);
  return {};
}

/// Removes the mesh and the trail from the page.
void ScanView::drop_mesh() {
  if (mesh_) revision_ = mesh_->revision() + 1;
  mesh_.reset();
  server_->clear(revision_);
}

void ScanView::on_tracked_mesh(const ScanState& scan) {
  if (server_ == nullptr) return;
  if (is_second_pass_) return on_refined(scan);
  show_all(scan.volume);
}

void ScanView::show_all(TsdfVolume& volume) {
  const StageTimer timer(times_["view_all"]);
  update_mesh(volume, kAll);
  publish_state(/*is_urgent=*/true);
}

void ScanView::on_refined(const ScanState& scan) {
  if (server_ == nullptr) return;
  state_.message.clear();
  drop_mesh();
  std::vector<Eigen::Vector3d> trail;
  for (const PosedFrame& frame : scan.trajectory) trail.push_back(frame.T_world_camera.translation());
  server_->publish_trail(trail);
  if (!scan.crop) publish_crop(std::nullopt);
  if (const auto made = make_mesh(scan.volume); !made) return console_.warn(made.error().text());
  show_all(scan.volume);
}

void ScanView::publish_files(const FilesByKind& files) {
  std::vector<std::filesystem::path> paths;
  for (const auto& [kind, path] : files) {
    if (kind == "glb" || kind == "stl" || kind == "ply" || kind == "obj") paths.emplace_back(path);
  }
  server_->publish_files(paths);
}

void ScanView::serve_result(const CommandRun& run) {
  if (server_ == nullptr) return;
  constexpr const char* kOver = "the scan is over";
  server_->refuse_commands(kOver);
  const bool has_succeeded = run.exit_code == kExitOk || run.exit_code == kExitInterrupted;
  state_.phase = has_succeeded ? ViewPhase::kFinished : ViewPhase::kFailed;
  state_.message = run.exit_code == kExitOk ? "" : run.status;
  for (const WarningCode of_crop : {WarningCode::kCropBoxIgnored, WarningCode::kCropBoxDropped}) {
    const ScanWarning* warning = find_warning(run.scan, of_crop);
    if (state_.message.empty() && warning != nullptr) state_.message = warning->text;
  }
  note_counts(run.scan.frames, run.scan.losses);
  publish_files(run.scan.files);
  publish_state(/*is_urgent=*/true);
  if (stop_.stop_requested() || run.scan.frames.fused == 0) return;
  console_.info("the live view stays open until Ctrl-C");
  while (!stop_.stop_requested()) {
    if (const auto command = server_->next_command(stop_, 1s)) server_->answer(*command, kOver);
  }
}

}  // namespace scanknit
