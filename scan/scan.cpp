#include "scan/scan.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "acquire/convert/cut_recording.h"
#include "scan/frames/budget_check.h"
#include "scan/frames/recorded_frames.h"
#include "scan/frames/settle_sensor.h"
#include "scan/refine/loop_refiner.h"
#include "scan/refine/turntable_refiner.h"
#include "scan/scan_pass.h"
#include "scan/settings_check.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// Refuses options for turntables where no turntable is scanned.
Result<void> check_is_turntable(const ScanJob& job) {
  if (!job.cut_recording && !job.angles) return {};
  if (job.config.turntable.is_enabled && job.config.acquire.poses != PoseMode::kStill) return {};
  return Error{ErrorCode::kUsage, fmt::format("{} is for turntables: give --preset turntable, and no --poses still",
                                              job.cut_recording ? "--cut-recording" : "--angles")};
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
      return Error{ErrorCode::kOutput, "lies in the recording itself; give another --cut-recording", folder.string()};
    }
  }
  for (const fs::path& mesh : job.files.meshes) {
    if (one_spelling_of(mesh).parent_path() == folder) {
      return Error{ErrorCode::kOutput,
                   "is where the mesh goes; give another --cut-recording, for example its folder turn",
                   folder.string()};
    }
  }
  return CutRecording::check(*job.cut_recording);
}

class RecordingScan {
 public:
  RecordingScan(const ScanJob& job, ScanObserver& observer, const std::stop_token& stop)
      : job_(job), session_(observer, stop), archive_(archive_of(job_)) {}

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = scan();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

 private:
  [[nodiscard]] Result<void> scan() {
    warn_of_settings_without_effect(job_, session_);
    if (auto sound = check_job(); !sound) return sound;
    if (auto opened = open(); !opened) return opened;
    const bool stands_still = source_->info().poses == PoseMode::kStill;
    if (!job_.config.turntable.is_enabled) return scan_walk();
    if (!stands_still) return scan_turntable();
    session_.warn(WarningCode::kNotATurntable,
                  "--poses still: nothing is taken to turn, and no turntable is looked for");
    return scan_walk();
  }

  [[nodiscard]] Result<void> check_job() const {
    if (auto writable = check_files(job_); !writable) return writable;
    if (auto asked = check_is_turntable(job_); !asked) return asked;
    return check_cut_recording(job_);
  }

  [[nodiscard]] Result<void> open() {
    auto opened = open_recording(job_.input, job_.config.acquire);
    if (!opened) return opened.error();
    for (const std::string& warning : (*opened)->info().warnings) session_.warn(WarningCode::kRecording, warning);
    settle_sensor((*opened)->info().sensor, job_.config, session_);
    source_ = paced(*std::move(opened), job_.pace, job_.pace_control());
    const PoseMode poses = source_->info().poses;
    if (auto fits = check_budget(job_.input, poses, job_.config, session_.stop()); !fits) return fits;
    return session_.observer().on_open(source_->info());
  }

  [[nodiscard]] Result<void> scan_walk() { return scan_walk(input_of(*source_)); }

  [[nodiscard]] Result<void> scan_walk(const PassInput& input) {
    const auto refiner = loop_refiner(job_.config, input.source.info().poses, archive_, session_);
    ScanPass pass(job_, input, *refiner, session_);
    const Result<void> scanned = pass.run();
    pass.describe(result_);
    return scanned;
  }

  /// Scans a turntable. If it turns out to be none, scans the recording as a walk.
  [[nodiscard]] Result<void> scan_turntable() {
    ScanJob turning = job_;
    turning.config.fusion.loop_closure = false;  // the turntable's own pairs close the turn
    TurntableRefiner turntable(turning, source_->info().poses, archive_, session_);
    const auto learned = turntable.learn();
    turntable.describe(result_);
    if (!learned) return learned;
    ScanPass pass(turning, input_of(*source_), turntable, session_);
    const Result<void> scanned = pass.run();
    turntable.conclude(/*has_mesh=*/scanned.has_value());
    pass.describe(result_);
    if (!scanned) return scanned;
    const bool was_a_walk = !turntable.changes_frames() && !(job_.config.fusion.loop_closure && result_.tracking);
    if (turntable.is_refined() || was_a_walk || session_.is_stopped()) return scanned;
    return scan_as_walk(pass, turntable);
  }

  /// Scans the same frames as the pass again, now as a walk: with everything that stands still.
  [[nodiscard]] Result<void> scan_as_walk(const ScanPass& pass, const TurntableRefiner& turntable) {
    const auto frames = open_frames(job_, &pass.intake().taken());
    if (!frames) return frames.error();
    PassInput input = input_of(**frames);
    input.counted = pass.intake().left_out();
    input.crop = pass.crop();
    FilesByKind files = std::move(result_.files);
    result_ = {};
    result_.files = std::move(files);
    const Result<void> scanned = scan_walk(input);
    turntable.describe(result_);
    return scanned;
  }

  [[nodiscard]] PassInput input_of(FrameSource& source) const {
    return {.source = source, .archive = archive_, .stop = session_.stop(), .is_paced = job_.pace == Pace::kRealtime};
  }

  ScanJob job_;  ///< its configuration is settled when the recording is open
  ScanSession session_;
  FrameArchive archive_;
  std::unique_ptr<FrameSource> source_;
  ScanResult result_;
};

}  // namespace

ScanResult scan_recording(const ScanJob& job, ScanObserver& observer, std::stop_token stop) {
  return RecordingScan(job, observer, stop).run();
}

}  // namespace scanknit
