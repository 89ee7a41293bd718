// A live scan: the frames come from a scanner, and are recorded at the same time.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "acquire/live/live_source.h"
#include "acquire/record/recorder.h"
#include "core/files/atomic_file.h"
#include "scan/frames/recorded_frames.h"
#include "scan/frames/settle_sensor.h"
#include "scan/live/live_scanner.h"
#include "scan/refine/loop_refiner.h"
#include "scan/refine/turntable_refiner.h"
#include "scan/scan.h"
#include "scan/scan_pass.h"
#include "scan/settings_check.h"
#include "scan/stage_times.h"

namespace scanknit {
namespace {

/// The error after the scanner failed: it also says what became of the frames until then.
Error failed_scan(const Error& failure, const Result<void>& meshed) {
  if (meshed) {
    return {ErrorCode::kDevice, fmt::format("{}; what was scanned until then has been meshed", failure.message)};
  }
  // Without a usable frame, the scanner's failure is the cause.
  const ErrorCode code = meshed.error().code == ErrorCode::kInput ? ErrorCode::kDevice : meshed.error().code;
  return {code, fmt::format("{}; of what was scanned until then: {}", failure.message, meshed.error().text())};
}

/// The times of those stages of a second pass that do not work on single frames.
StageTimesByName times_after_frames(const StageTimesByName& times) {
  StageTimesByName chosen;
  for (const char* stage : {"refine", "fuse_again", "extract", "finish", "export", "texture", "write"}) {
    const auto found = times.find(stage);
    if (found != times.end()) chosen.insert(*found);
  }
  return chosen;
}

class LiveScan {
 public:
  LiveScan(const ScanJob& job, const LiveScanRequest& request, ScanObserver& observer, const std::stop_token& stop)
      : job_(job), request_(request), stop_(stop), session_(observer, {}) {}

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = scan();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

 private:
  [[nodiscard]] Result<void> scan() {
    warn_of_settings_without_effect(job_, session_);
    if (auto sound = check_job(); !sound) return sound;
    if (auto opened = session_.observer().on_open({}); !opened) return opened;
    if (auto started = start(); !started) return started;
    const Result<void> meshed = scan_turntable(scan_frames());
    return source_->failure() ? failed_scan(*source_->failure(), meshed) : meshed;
  }

  [[nodiscard]] Result<void> check_job() const {
    const PoseMode poses = job_.config.acquire.poses;
    if (poses == PoseMode::kRecording || poses == PoseMode::kRefine) {
      return Error{ErrorCode::kUsage, "a scanner knows no poses: --poses track (the default) or still"};
    }
    if (job_.config.output.texture != TextureFormat::kOff && !request_.recording) {
      return Error{ErrorCode::kUsage,
                   "export.texture is baked from the recording: leave out --no-recording, or leave the texture off"};
    }
    return check_files(job_);
  }

  [[nodiscard]] Result<void> start() {
    auto scanner = open_scanner(request_.scanner, job_.config, Calibration::kRequired, stop_, session_);
    if (!scanner) return scanner.error();
    result_.input = scanner->device->info().uri;
    if (auto opened = open_recorder(scanner->calibration); !opened) return opened;
    const bool stands_still = job_.config.acquire.poses == PoseMode::kStill;
    LiveOptions options = live_options(request_.scanner, stands_still ? PoseMode::kStill : PoseMode::kTrack, session_);
    options.on_recorder_failure = [this](const Error& error) {
      session_.warn(WarningCode::kRecorder, error.text() + "; the scan goes on");
      has_warned_of_recorder_ = true;
    };
    auto source = LiveSource::start(*std::move(scanner), std::move(options), recorder_.get());
    if (!source) return source.error();
    source_ = *std::move(source);
    settle_sensor(source_->info().sensor, job_.config, session_);
    is_recording_ = recorder_ != nullptr;
    has_recording_ = is_recording_;
    session_.info("scanning; Ctrl-C ends the scan and makes the mesh");
    return {};
  }

  [[nodiscard]] Result<void> open_recorder(const RawCalibration& calibration) {
    if (!request_.recording) return {};
    if (auto writable = check_writable(*request_.recording); !writable) return writable;
    auto recorder = Recorder::create(*request_.recording, calibration);
    if (!recorder) return recorder.error();
    recorder_ = *std::move(recorder);
    session_.info(fmt::format("recording to {}", request_.recording->string()));
    return {};
  }

  /// Scans the frames as they come. Ctrl-C ends the frames; the steps after them still run.
  [[nodiscard]] Result<void> scan_frames() {
    const FrameArchive archive = is_recording_ ? FrameArchive([this](std::size_t every) {
      finish_recording();
      AcquireConfig config = job_.config.acquire;
      config.every *= every;
      return open_recording(*request_.recording, config);
    })
                                               : FrameArchive();
    const auto refiner = loop_refiner(job_.config, source_->info().poses, archive, session_);
    const PassInput input{
        .source = *source_, .archive = archive, .stop = stop_, .is_paced = true, .losses = [this] { return losses(); }};
    ScanPass pass(job_, input, *refiner, session_);
    const Result<void> scanned = pass.run();
    finish_recording();
    result_.losses = losses();
    warn_of_losses(*result_.losses, session_);
    pass.describe(result_);
    if (has_recording_) result_.files["recording"] = request_.recording->string();
    taken_ = pass.intake().taken();
    left_out_ = pass.intake().left_out();
    crop_ = pass.crop();
    return scanned;
  }

  /// The mesh of the tracked frames is already on disk; the mesh of the refined turntable replaces it. A second Ctrl-C
  /// keeps the first mesh.
  [[nodiscard]] Result<void> scan_turntable(const Result<void>& meshed) {
    if (!job_.config.turntable.is_enabled || job_.config.acquire.poses == PoseMode::kStill) return meshed;
    if (!has_recording_) {
      session_.warn(WarningCode::kTurntableNotTried, "turntable: without a recording the mesh is the tracked one");
      return meshed;
    }
    session_.info("finding the axis and the angles of the turntable; Ctrl-C leaves the mesh as it is");
    const auto refined = scan_recorded_turntable();
    if (refined && *refined) return {};
    if (!refined) {
      session_.warn(WarningCode::kTurntableNotTried,
                    fmt::format("turntable: {}; the mesh is the tracked one", refined.error().text()));
    }
    return meshed;
  }

  /// Makes a second pass, over the recording. False: it is no turntable, and the result stays that of the first pass.
  [[nodiscard]] Result<bool> scan_recorded_turntable() {
    ScanJob recorded = job_;
    recorded.input = *request_.recording;
    const auto source = open_frames(recorded, &taken_);
    if (!source) return source.error();
    const FrameArchive archive = archive_of(recorded, &taken_);
    ScanSession session(session_.observer(), {});
    TurntableRefiner turntable(recorded, (*source)->info().poses, archive, session);
    const auto scanned = [&]() -> Result<void> {
      if (auto learned = turntable.learn(); !learned) return learned;
      ScanPass pass(
          recorded,
          {.source = **source, .archive = archive, .writes_tracked_mesh = false, .counted = left_out_, .crop = crop_},
          turntable, session);
      const Result<void> passed = pass.run();
      if (turntable.is_refined()) pass.describe(result_);
      return passed;
    }();
    turntable.describe(result_);
    if (turntable.is_refined()) {
      session_.begin_mesh();
      result_.loops.reset();  // they belong to the first pass, whose poses were replaced
    }
    result_.warnings = session.warnings();
    add_times(times_after_frames(session.times()), result_.stages);
    if (!scanned) return scanned.error();
    return turntable.is_refined();
  }

  void finish_recording() {
    if (!std::exchange(is_recording_, false)) return;
    const auto kept = recorder_->finish();
    if (!kept && !has_warned_of_recorder_) session_.warn(WarningCode::kRecorder, kept.error().text());
    if (kept && kept->frames == 0) has_recording_ = false;
  }

  [[nodiscard]] LossCounters losses() const {
    LossCounters losses = source_->losses();
    if (recorder_ != nullptr) losses.writer += recorder_->lost();
    return losses;
  }

  ScanJob job_;  ///< its configuration is settled when the scanner is open
  const LiveScanRequest& request_;
  std::stop_token stop_;  ///< ends the frames
  ScanSession session_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<LiveSource> source_;
  bool is_recording_ = false;   ///< the recorder is still writing pictures
  bool has_recording_ = false;  ///< there is a recording, with pictures in it
  bool has_warned_of_recorder_ = false;
  SequenceRanges taken_;
  FrameCounts left_out_;
  CropBox crop_;
  ScanResult result_;
};

}  // namespace

ScanResult scan_live(const ScanJob& job, const LiveScanRequest& request, ScanObserver& observer, std::stop_token stop) {
  return LiveScan(job, request, observer, stop).run();
}

}  // namespace scanknit
