#include "scan/scan.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "acquire/convert/cut_recording.h"
#include "acquire/lidar/sweep_source.h"
#include "scan/bricks/bricks_check.h"
#include "scan/bricks/scan_in_bricks.h"
#include "scan/checks/budget_check.h"
#include "scan/checks/settings_check.h"
#include "scan/classes/scan_classes.h"
#include "scan/find_poses.h"
#include "scan/frames/recorded_frames.h"
#include "scan/lidar/scan_sweeps.h"
#include "scan/passes.h"
#include "scan/silhouettes/scan_silhouettes.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// Refuses options for turntables where no turntable is scanned.
Result<void> check_is_turntable(const ScanJob& job) {
  if (!job.cut_recording && !job.angles) return {};
  if (job.config.turntable.is_enabled && job.config.acquire.poses != PoseMode::kStill) return {};
  return Error{ErrorCode::kUsage,
               fmt::format("{} only of a turntable: set turntable.enabled, and do not set acquire.poses=still",
                           job.cut_recording ? "a cut recording is made" : "angles are known")};
}

/// One spelling of a path, whether or not it exists.
fs::path one_spelling_of(const fs::path& path) {
  std::error_code code;
  const fs::path whole = fs::weakly_canonical(fs::absolute(path, code), code);
  return whole.has_filename() ? whole : whole.parent_path();
}

/// Checks, before any work, that the folder does not exist or is empty, and that nothing else is or will be written
/// there.
Result<void> check_cut_recording(const ScanJob& job) {
  if (!job.cut_recording) return {};
  const fs::path folder = one_spelling_of(*job.cut_recording);
  const fs::path input = one_spelling_of(job.input);
  for (fs::path at = folder; at != at.parent_path(); at = at.parent_path()) {
    if (at == input) {
      return Error{ErrorCode::kOutput, "lies in the recording itself; choose another folder for the cut recording",
                   folder.string()};
    }
  }
  for (const fs::path& mesh : job.files.meshes) {
    if (one_spelling_of(mesh).parent_path() == folder) {
      return Error{ErrorCode::kOutput,
                   "is where the mesh goes; choose another folder for the cut recording, for example turn in it",
                   folder.string()};
    }
  }
  return CutRecording::check(*job.cut_recording);
}

class RecordingScan {
 public:
  RecordingScan(const ScanJob& job, ScanObserver& observer, const std::stop_token& stop)
      : job_(job), session_(observer, stop), archive_(archive_of(job_)) {
    job_.config.acquire.keeps_masks = job_.config.fusion.silhouettes == SilhouetteUse::kCarve;
  }

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = scan();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

  /// Of a recording whose poses are tracked.
  [[nodiscard]] FoundPoses find_poses() {
    makes_mesh_ = false;
    ScanResult scan = run();
    return {std::move(scan), std::move(fused_), std::move(samples_)};
  }

 private:
  [[nodiscard]] Result<void> scan() {
    if (makes_mesh_) warn_of_settings(job_, session_);
    if (auto sound = check_job(); !sound) return sound;
    if (auto opened = open(); !opened) return opened;
    const bool stands_still = source_->info().poses == PoseMode::kStill;
    if (!job_.config.turntable.is_enabled) return walk();
    if (!stands_still) return turn();
    session_.warn(WarningCode::kNoTurntable, "acquire.poses is still: nothing turns, so no turntable is looked for");
    return walk();
  }

  [[nodiscard]] Result<void> check_job() const {
    if (auto writable = check_files(job_); !writable) return writable;
    if (auto asked = check_is_turntable(job_); !asked) return asked;
    if (auto masked = check_carving(job_.config); !masked) return masked;
    return check_cut_recording(job_);
  }

  [[nodiscard]] Result<void> open() {
    auto opened = open_first(job_, session_);
    if (!opened) return opened.error();
    possible_timing_ = opened->possible_timing;
    source_ = paced(std::move(opened->source), job_.pace, job_.pace_control());
    if (auto fits = choose_bricks(); !fits) return fits;
    return session_.observer().on_open(source_->info());
  }

  /// Whether the volume is fused in bricks. Errors: those of check_budget(), if it cannot be.
  [[nodiscard]] Result<void> choose_bricks() {
    if (!makes_mesh_) return {};  // its poses are tracked: the volume may stop growing
    const PoseMode poses = source_->info().poses;
    const BrickSize asked = job_.config.fusion.bricks;
    const bool is_asked = asked != BrickSize::kOff && asked != BrickSize::kAuto;
    const Result<void> possible = is_asked ? check_bricks(job_, poses) : check_coarse_bricks(job_, poses);
    if (is_asked && !possible) {
      session_.warn(WarningCode::kNoEffect, "fusion.bricks has no effect: " + possible.error().message);
    }
    may_use_bricks_ = asked != BrickSize::kOff && possible;
    if (may_use_bricks_) {
      const auto sound = TsdfVolume::create(job_.config.fusion);
      uses_bricks_ = sound && (is_asked || !fits_into_budget(job_, session_.stop()));
      return sound ? Result<void>() : sound.error();
    }
    auto fits = check_budget(job_, poses, session_.stop());
    if (fits || fits.error().code != ErrorCode::kBudget || asked == BrickSize::kOff) return fits;
    Error error = fits.error();
    error.message += "; " + possible.error().message;
    return error;
  }

  /// If frames fit badly where the camera turns quickly, and the sensor may have a rolling shutter, scans them again
  /// with it; and once more without it if they hardly fit better.
  [[nodiscard]] Result<void> walk() {
    constexpr double kMostMisfit = 0.03;  // 0.014 to 0.02 where the timing is known, 0.06 to 0.34 where it is not
    constexpr double kBetter = 0.8;       // with the shutter that a sensor has, a third is left
    PassInput input = input_of(*source_);
    if (uses_bricks_) return keep_in_bricks(input);
    input.limits.gives_up_when_full = may_use_bricks_;
    if (possible_timing_) input.limits.most_misfit = kMostMisfit;
    PassResult first = scan_walk(job_, input, session_);
    if (!first.has_given_up) return keep(std::move(first));
    if (may_use_bricks_) return walk_in_bricks();  // known poses are given up for nothing but a full volume
    session_.info(
        fmt::format("the camera turned quickly, and {:.1f} % of the frames' points do not fit there: the frames are "
                    "scanned again with a rolling shutter of {:.0f} ms",
                    *first.misfit * 100, possible_timing_->readout_s * 1000));
    const AcquireConfig without_timing = job_.config.acquire;
    job_.config.acquire.readout_s = possible_timing_->readout_s;
    job_.config.acquire.colour_later_s = possible_timing_->colour_later_s;
    const PassLimits limits{.most_misfit = kBetter * *first.misfit,
                            .most_lost_before_search = first.scan.frames.lost + first.scan.tracking->found_later};
    PassResult timed = walk_again(first, limits);
    if (!timed.has_given_up) return keep(std::move(timed));
    session_.info("the rolling shutter hardly improves the fit: the frames are scanned again without it");
    job_.config.acquire = without_timing;
    return keep(walk_again(std::move(first)));
  }

  /// Scans the recording again, from its beginning: its volume turned out to exceed the budget.
  [[nodiscard]] Result<void> walk_in_bricks() {
    const auto frames = open_frames(job_);
    return frames ? keep_in_bricks(input_of(**frames)) : frames.error();
  }

  [[nodiscard]] Result<void> keep_in_bricks(const PassInput& input) {
    if (job_.config.fusion.bricks != BrickSize::kAuto) return keep_in_parts(input);
    session_.info("the volume needs more than fusion.memory_budget: what the camera does not see is kept on the disk");
    if (auto paged = scan_in_pages(job_, input, session_)) {
      result_ = *std::move(paged);
      return result_.outcome;
    }
    const auto frames = open_frames(job_);
    return frames ? keep_in_parts(input_of(**frames)) : frames.error();
  }

  [[nodiscard]] Result<void> keep_in_parts(const PassInput& input) {
    result_ = scan_in_parts(job_, input, session_);
    return result_.outcome;
  }

  /// Scans a turntable. If it turns out to be none, scans the recording as a walk.
  [[nodiscard]] Result<void> turn() {
    PassResult turned = scan_turntable(job_, input_of(*source_), session_);
    const bool has_still_scene = turned.scan.turntable->has_still_scene;
    const bool differs_from_walk = turned.scan.tracking && (has_still_scene || job_.config.fusion.loop_closure);
    const bool is_done = !turned.scan.outcome || turned.scan.turntable->is_refined || session_.is_stopped();
    return keep(is_done || !differs_from_walk ? std::move(turned) : walk_again(std::move(turned)));
  }

  /// Scans the same frames again, as a walk.
  [[nodiscard]] PassResult walk_again(PassResult first, const PassLimits& limits = {}) {
    const auto frames = open_frames(job_, &first.taken);
    if (!frames) {
      first.scan.outcome = frames.error();
      first.has_given_up = false;
      return first;
    }
    PassInput input = input_of(**frames);
    input.limits = limits;
    input.counted = first.left_out;
    input.crop = first.crop;
    PassResult walked = scan_walk(job_, input, session_);
    walked.scan = replacing(std::move(first.scan), std::move(walked.scan));
    return walked;
  }

  Result<void> keep(PassResult made) {
    fused_ = std::move(made.fused);
    samples_ = std::move(made.samples);
    result_ = std::move(made.scan);
    return result_.outcome;
  }

  [[nodiscard]] PassInput input_of(FrameSource& source) const {
    return {.source = source,
            .archive = archive_,
            .stop = session_.stop(),
            .is_paced = job_.pace == Pace::kRealtime,
            .makes_mesh = makes_mesh_};
  }

  ScanJob job_;  ///< its configuration is complete when the recording is open
  ScanSession session_;
  FrameArchive archive_;
  std::unique_ptr<FrameSource> source_;
  bool may_use_bricks_ = false;  ///< if the volume exceeds its budget
  bool uses_bricks_ = false;
  bool makes_mesh_ = true;
  std::vector<std::uint64_t> fused_, samples_;  ///< of the pass that was kept
  std::optional<FrameTiming> possible_timing_;  ///< of a sensor that may be simulated: apply_sensor()
  ScanResult result_;
};

}  // namespace

ScanResult scan_recording(const ScanJob& job, ScanObserver& observer, std::stop_token stop) {
  if (job.meshes_each_class) return scan_classes(job, observer, stop);
  if (job.config.acquire.geometry == Geometry::kSilhouettes) return scan_silhouettes(job, observer, stop);
  if (!job.rig && is_sweep_recording(job.input, job.config.acquire)) return scan_sweeps(job, observer, stop);
  return RecordingScan(job, observer, stop).run();
}

FoundPoses find_poses(const ScanJob& asked, ScanObserver& observer, std::stop_token stop) {
  ScanJob job = asked;
  job.files = {};
  job.measures_fit = true;  // which keeps samples
  return RecordingScan(job, observer, stop).find_poses();
}

}  // namespace scanknit
