#include "scan/scan_pass.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/system/freed_memory.h"
#include "fusion/register/motion_vector.h"
#include "scan/checks/memory_share.h"
#include "scan/checks/tracking_verdict.h"
#include "scan/frames/fuse_again.h"
#include "scan/mesh/write_surface.h"
#include "scan/pose_finder.h"
#include "scan/silhouettes/carve_gaps.h"
#include "scan/volume/write_beside_mesh.h"

namespace scanknit {
namespace {

/// The sequence numbers of frames at which the camera turned quickly. Without a clock, frames count as a second apart.
std::set<std::uint64_t> frames_in_quick_turns(const Trajectory& trajectory) {
  constexpr double kLongest_s = 0.15;
  constexpr double kQuick_rad_per_s = 1.2;  // a hand that walks turns by up to 0.9
  std::set<std::uint64_t> frames;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const double apart_s = trajectory[i].stamp - trajectory[i - 1].stamp;
    if (!(apart_s > 0 && apart_s <= kLongest_s)) continue;
    const Pose turn = trajectory[i - 1].T_world_camera.inverse() * trajectory[i].T_world_camera;
    if (angle_of(turn) / apart_s >= kQuick_rad_per_s) frames.insert(trajectory[i].sequence);
  }
  return frames;
}

/// ScanPass::misfit().
std::optional<double> misfit_in_quick_turns(const Trajectory& trajectory, const TrackingResult& tracking) {
  constexpr std::size_t kFewest = 5;
  const std::set<std::uint64_t> quick = frames_in_quick_turns(trajectory);
  if (quick.empty()) return std::nullopt;
  double misfit = 0;
  std::size_t frames = 0;
  for (const TrackedFrame& frame : tracking.frames) {
    const bool is_lost = frame.state == TrackState::kLost;
    if (is_lost ? !has_seen_enough(frame) : !quick.contains(frame.sequence)) continue;
    misfit += is_lost ? 1 : 1 - frame.inlier_share;
    ++frames;
  }
  return frames >= kFewest ? std::optional(misfit / static_cast<double>(frames)) : std::nullopt;
}

}  // namespace

ScanPass::ScanPass(const ScanJob& job, const PassInput& input, PoseRefiner& refiner, ScanSession& session)
    : job_(job),
      input_(input),
      refiner_(refiner),
      session_(session),
      intake_(input.source, job.config.acquire, session, {input.stop, input.counted}),
      crop_(input.crop) {}

Result<void> ScanPass::run() {
  if (auto begun = begin(); !begun) return begun;
  if (auto fused = track_and_fuse(); !fused) return fused;
  find_lost();
  if (auto fits = check_misfit(); !fits) return fits;
  if (auto written = write_tracked(); !written) return written;
  if (auto refined = refine(); !refined) return refined;
  if (!input_.makes_mesh) return {};
  if (auto extracted = extract_and_write(); !extracted) return extracted;
  return write_texture();
}

Result<void> ScanPass::begin() {
  if (auto prepared = refiner_.prepare(); !prepared) return prepared;
  const bool keeps_depth_samples =
      job_.measures_fit || job_.config.finish.drops_crumbs || job_.config.output.uncertainty;
  const Reconstruction::Options options{intake_.info().poses, keeps_depth_samples, !input_.limits.gives_up_when_full};
  auto scan = Reconstruction::create(job_.config, options, refiner_, session_);
  if (!scan) return scan.error();
  scan_.emplace(*std::move(scan));
  return session_.observer().on_begin(state());
}

Result<void> ScanPass::track_and_fuse() {
  const std::size_t most_lost = input_.limits.most_lost_before_search;
  while (!intake_.is_over()) {
    if (auto frame = intake_.next()) {
      if (auto added = add(*frame); !added) return added;
      if (intake_.counts().lost > most_lost && !session_.is_stopped()) return give_up();
      if (input_.limits.gives_up_when_full && scan_->is_budget_reached()) return give_up();
    } else {
      session_.observer().on_no_frame(nullptr, state());
    }
    carry_out_commands();
  }
  was_full_ = scan_->is_budget_reached();
  return {};
}

/// Looks again at the frames that were lost: what was scanned after them is known now. Without them, the scan goes on.
void ScanPass::find_lost() {
  const bool has_lost = scan_->tracking() && intake_.counts().lost > 0 && intake_.counts().fused > 0;
  if (!has_lost || session_.is_stopped() || !input_.archive.is_kept() || refiner_.recovers_lost_scans()) return;
  enter(ScanPhase::kWriting);
  constexpr std::size_t kWorthLookingAgain = 16;  // frames: LostFrames keeps only some of a long gap at a time
  std::size_t fused = 0;
  Result<void> found;
  do {
    fused = scan_->trajectory().size();
    const auto source = input_.archive.open();
    found = source ? scan_->find_lost(**source) : source.error();
    intake_.recount(scan_->trajectory().size());
  } while (found && intake_.counts().lost > 0 && scan_->trajectory().size() >= fused + kWorthLookingAgain);
  if (found) return;
  session_.warn(WarningCode::kLostNotSearched,
                "frames that were lost could not be looked for again: " + found.error().text());
}

/// An error when the pass gives up.
Result<void> ScanPass::check_misfit() {
  if (scan_->tracking()) misfit_ = misfit_in_quick_turns(scan_->trajectory(), *scan_->tracking());
  if (!misfit_ || *misfit_ <= input_.limits.most_misfit || session_.is_stopped()) return {};
  return give_up();
}

Result<void> ScanPass::give_up() {
  has_given_up_ = true;
  return Error{ErrorCode::kTooLittle, "this pass was given up: its limits are reached (PassLimits)"};
}

/// Writes the mesh of a scanner's tracked frames first, so that it exists whatever happens later. A recording's frames
/// can be scanned again: their mesh is written when it is certain that no better one comes.
Result<void> ScanPass::write_tracked() {
  if (!input_.writes_tracked_mesh) return {};
  const TrackedScan tracked{scan_->tracking(), intake_.counts(), was_full_};
  tracking_verdict_ = check_tracking(tracked);
  if (auto usable = intake_.conclude(); !usable) return tracking_verdict_ ? usable : tracking_verdict_;
  enter(ScanPhase::kWriting);
  if (auto saved = write_volume_and_trajectory(); !saved) return saved;
  const bool is_full = !tracking_verdict_ && tracking_verdict_.error().code == ErrorCode::kBudget;
  if (!tracking_verdict_ && !is_full) return {};
  if (is_full || input_.is_paced) {
    if (auto written = write_tracked_mesh(IsLastMesh::kNo); !written) return written;
  }
  return tracking_verdict_;
}

Result<void> ScanPass::write_tracked_mesh(IsLastMesh is_last) {
  if (!input_.makes_mesh) return {};
  auto written = write_mesh(is_last);
  session_.observer().on_tracked_mesh(state());
  return written;
}

/// If the refiner finds better poses, fuses all frames again at these.
Result<void> ScanPass::refine() {
  if (tracking_verdict_ || refiner_.recovers_lost_scans()) {
    const auto make_room_early = [this] {
      if (!session_.observer().needs_volume_after_mesh()) room_ = make_room();
      return room_;
    };
    const auto better = refiner_.refine({scan_->trajectory(), scan_->tracking(), make_room_early});
    return_freed_memory();
    if (!room_) return room_;
    if (!better) return after_tracked_mesh(better.error());
    const auto fused = *better ? fuse_again(**better) : Result<bool>(false);
    if (!room_) return room_;
    if (!fused) return after_tracked_mesh(fused.error());
    is_refined_ = *fused;
    if (is_refined_) find_lost();  // in a model that is straight, frames fit that did not fit before
  }
  if (!tracking_verdict_ && !is_refined_ && !session_.is_stopped()) return tracking_verdict_;
  const bool recovers_lost = is_refined_ && refiner_.recovers_lost_scans();
  const auto warning = tracking_warning({scan_->tracking(), intake_.counts(), was_full_});
  if (warning && input_.writes_tracked_mesh && !recovers_lost) session_.warn(WarningCode::kTrackingLost, *warning);
  return {};
}

/// Extracts, finishes and writes the mesh, unless that of the tracked frames is written already and stays.
Result<void> ScanPass::extract_and_write() {
  if (is_refined_) {
    session_.observer().on_refined(state());
    if (auto saved = write_volume_and_trajectory(); !saved) return saved;
    return write_mesh(IsLastMesh::kYes);
  }
  if (written_ || !input_.writes_tracked_mesh) return {};
  return write_tracked_mesh(
      IsLastMesh::kYes);  // also after an interruption: a mesh of the tracked frames is better than none
}

/// The error that ended the refinement, once the mesh of the tracked frames is written.
Error ScanPass::after_tracked_mesh(Error error) {
  if (!written_ && input_.writes_tracked_mesh && tracking_verdict_) (void)write_tracked_mesh(IsLastMesh::kNo);
  return error;
}

/// Makes room for a second volume: writes the first one's mesh and empties it, unless both fit into the budget. After
/// an error, the volume may be empty and its mesh not written.
Result<void> ScanPass::make_room() {
  constexpr std::size_t kMebibyte = 1024 * 1024;
  const std::size_t both_mib = 2 * scan_->volume().memory_bytes() / kMebibyte + kProgramMib;
  const bool fit_both = both_mib <= job_.config.fusion.memory_budget_mib;
  const bool may_write = input_.writes_tracked_mesh && tracking_verdict_;
  if (!written_) {
    if (fit_both || !may_write) return {};
    if (auto written = write_tracked_mesh(IsLastMesh::kYes); !written) return written;
  }
  return empty_volume();
}

Result<void> ScanPass::empty_volume() {
  auto empty = TsdfVolume::create(volume_config(job_.config.fusion));
  if (!empty) return empty.error();
  scan_->volume() = *std::move(empty);
  return_freed_memory();
  return {};
}

/// True when the scan has changed.
Result<bool> ScanPass::fuse_again(const Trajectory& trajectory) {
  const auto source = input_.archive.open();
  if (!source) return source.error();
  auto volume = TsdfVolume::create(volume_config(job_.config.fusion));
  if (!volume) return volume.error();
  if (room_ = make_room(); !room_) return room_.error();
  const FramesToFuse frames{trajectory, [this](Frame& frame) { refiner_.edit_for_fusion(frame); }};
  const auto fused = session_.timed(
      "fuse_again", [&] { return scanknit::fuse_again(**source, frames, job_.config, *volume, session_); });
  if (!fused || *fused < trajectory.size()) {
    if (auto left = refiner_.reject(fused); !left) return left.error();
    return false;
  }
  if (auto accepted = refiner_.accept(*volume); !accepted) return accepted.error();
  if (volume->is_budget_reached && !was_full_) {
    session_.warn(WarningCode::kBudgetReached,
                  "at the corrected poses the volume has reached fusion.memory_budget: the mesh is incomplete");
  }
  scan_->replace(*std::move(volume), trajectory, refiner_.result().recovered);
  intake_.recount(trajectory.size());
  if (refiner_.moves_the_world() && crop_) {
    session_.warn(
        WarningCode::kCropBoxDropped,
        "with better poses the scan lies elsewhere, so the crop box does not fit any more: the mesh is whole; "
        "finish.crop crops it");
  }
  if (refiner_.moves_the_world()) crop_.reset();
  return true;
}

Result<void> ScanPass::write_texture() {
  if (!written_) return {};
  TexturedMesh textured = write_textured(*written_, job_, input_.archive, session_);
  texture_ = std::move(textured.texture);
  return textured.outcome;
}

Result<void> ScanPass::add(Frame& frame) {
  const auto added = scan_->add(frame);
  if (!added) return added.error();
  intake_.count(frame, *added);
  phase_ = ScanPhase::kScanning;
  session_.observer().on_frame(frame, added->T_world_camera, state());
  return {};
}

/// Before the mesh: silhouettes fill what depth left; the volume's file gets it, too.
Result<void> ScanPass::carve_gaps() {
  if (job_.config.fusion.silhouettes != SilhouetteUse::kCarve || !input_.archive.is_kept()) return {};
  if (session_.is_stopped() || scan_->trajectory().empty()) return {};
  const GapsToCarve gaps{job_.config, scan_->trajectory(), input_.archive, refiner_.kept_space()};
  auto carved = scanknit::carve_gaps(gaps, scan_->volume(), session_);
  if (!carved) return carved.error();
  silhouettes_ = *std::move(carved);
  return silhouettes_ ? write_volume_and_trajectory() : Result<void>();
}

Result<void> ScanPass::write_mesh(IsLastMesh is_last) {
  if (auto carved = carve_gaps(); !carved) return carved;
  MeshRequest request{job_, intake_.info().world_up, crop_, EmptyCrop::kIgnored, input_.stop};
  const bool frees_volume = is_last == IsLastMesh::kYes && !session_.observer().needs_volume_after_mesh();
  if (frees_volume) request.on_volume_read = [this] { (void)empty_volume(); };  // its settings have made one before
  return_freed_memory();
  MeshedScan meshed = mesh_scan(*scan_, request, session_);
  mesh_ = std::move(meshed.result);
  if (meshed.outcome) written_ = std::move(meshed.written);
  return meshed.outcome;
}

Result<void> ScanPass::write_volume_and_trajectory() {
  volume_ = described(scan_->volume());
  std::optional<double> sigma_m;
  if (job_.files.volume) sigma_m = view_sigma_m(scan_->volume(), scan_->depth_samples(), job_.config);
  return write_beside_mesh(scan_->volume(), scan_->trajectory(), job_, session_, files_, sigma_m);
}

ScanState ScanPass::state() {
  const auto& tracking = scan_->tracking();
  const bool has_tracked = tracking && !tracking->frames.empty();
  return {.phase = phase_,
          .info = intake_.info(),
          .frames = intake_.counts(),
          .trajectory = scan_->trajectory(),
          .newest = has_tracked ? &tracking->frames.back() : nullptr,
          .trouble = intake_.trouble(),
          .crop = crop_,
          .losses = input_.losses ? std::optional(input_.losses()) : std::nullopt,
          .volume = scan_->volume()};
}

void ScanPass::enter(ScanPhase phase) {
  phase_ = phase;
  session_.observer().on_phase(state());
}

void ScanPass::enter_phase_of_frames() {
  phase_ = intake_.counts().fused + intake_.counts().lost > 0 ? ScanPhase::kScanning : ScanPhase::kWaiting;
}

void ScanPass::carry_out_commands() {
  while (!intake_.is_over()) {
    const auto command = session_.observer().next_command(input_.stop, std::chrono::nanoseconds(0));
    if (!command) break;
    carry_out(*command);
  }
  if (phase_ == ScanPhase::kPaused) wait_while_paused();
}

void ScanPass::carry_out(const ScanCommand& command) {
  Result<void> outcome;
  FilesByKind files;
  switch (command.kind) {
    case ScanCommand::Kind::kStart: enter_phase_of_frames(); break;
    case ScanCommand::Kind::kPause: phase_ = ScanPhase::kPaused; break;
    case ScanCommand::Kind::kReset: outcome = start_over(); break;
    case ScanCommand::Kind::kExport: outcome = export_now(files); break;
    case ScanCommand::Kind::kFinish: intake_.finish(); break;
    case ScanCommand::Kind::kCrop: crop_ = command.box; break;
  }
  session_.observer().on_answer(command, outcome, files, state());
}

void ScanPass::wait_while_paused() {
  using namespace std::chrono_literals;
  enter(ScanPhase::kPaused);
  while (phase_ == ScanPhase::kPaused && !intake_.is_over() && !input_.stop.stop_requested()) {
    const auto command = session_.observer().next_command(input_.stop, input_.is_paced ? 0ns : 500ms);
    if (command) {
      carry_out(*command);
      continue;
    }
    const auto frame = input_.is_paced ? intake_.skip_frame("paused") : std::nullopt;
    session_.observer().on_no_frame(frame ? &*frame : nullptr, state());
  }
}

Result<void> ScanPass::start_over() {
  if (auto begun = scan_->start_over(); !begun) return begun;
  intake_.start_over();
  if (is_tracked(intake_.info().poses)) crop_.reset();  // the box does not apply to the refined world
  session_.warn(WarningCode::kReset, "started over after frame " + std::to_string(intake_.counts().read));
  return session_.observer().on_begin(state());
}

/// Writes the mesh of the frames so far, while the scan waits. It is not part of the result.
Result<void> ScanPass::export_now(FilesByKind& files) {
  const ScanPhase before = phase_;
  enter(ScanPhase::kExporting);
  ScanObserver no_observer;
  ScanSession session(no_observer, session_.stop());
  const MeshRequest request{job_, intake_.info().world_up, crop_, EmptyCrop::kRefused, input_.stop};
  MeshedScan meshed = mesh_scan(*scan_, request, session);
  phase_ = before;
  if (meshed.outcome) files = std::move(meshed.result.files);
  return meshed.outcome;
}

std::vector<std::uint64_t> ScanPass::fused_order() const {
  return scan_ ? scan_->fused_order() : std::vector<std::uint64_t>();
}

std::vector<std::uint64_t> ScanPass::sample_sequences() const {
  return scan_ ? scan_->sample_sequences() : std::vector<std::uint64_t>();
}

ScanResult ScanPass::result() const {
  ScanResult result;
  RefinerResult refined = refiner_.result();
  result.frames = intake_.counts();
  result.volume = volume_;
  result.mesh = mesh_;
  result.silhouettes = silhouettes_;
  result.texture = texture_;
  result.loops = std::move(refined.loops);
  result.turntable = std::move(refined.turntable);
  for (const FilesByKind& files : {files_, mesh_.files, refined.files}) {
    for (const auto& [kind, path] : files) result.files[kind] = path;
  }
  if (scan_) {
    result.tracking = scan_->tracking();
    result.trajectory = scan_->trajectory();
  }
  return result;
}

}  // namespace scanknit
