// A live scan: the frames come from a scanner, and are recorded at the same time.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "acquire/live/live_source.h"
#include "acquire/record/recorder.h"
#include "acquire/sensor/scanner_camera.h"
#include "core/files/atomic_file.h"
#include "scan/checks/settings_check.h"
#include "scan/frames/apply_sensor.h"
#include "scan/frames/read_ahead.h"
#include "scan/frames/recorded_frames.h"
#include "scan/live/live_scanner.h"
#include "scan/passes.h"
#include "scan/scan.h"
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
    warn_of_settings(job_, session_);
    if (auto sound = check_job(); !sound) return sound;
    if (auto opened = session_.observer().on_open({}); !opened) return opened;
    if (auto started = start(); !started) return started;
    PassResult made = scan_frames();
    refine_turntable(made);
    result_ = std::move(made.scan);
    return source_->failure() ? failed_scan(*source_->failure(), result_.outcome) : result_.outcome;
  }

  [[nodiscard]] Result<void> check_job() const {
    if (auto good = check_cameras(job_.config.acquire); !good) return good;
    const PoseMode poses = job_.config.acquire.poses;
    if (poses == PoseMode::kRecording || poses == PoseMode::kRefine) {
      return Error{ErrorCode::kUsage, "a scanner knows no poses: acquire.poses is track (the default) or still"};
    }
    if (job_.config.fusion.silhouettes == SilhouetteUse::kCarve) {
      return Error{
          ErrorCode::kUsage,
          "a scanner's frames have no masks: record first, and run the recording with fusion.silhouettes=carve"};
    }
    if (job_.config.acquire.geometry == Geometry::kSilhouettes) {
      return Error{
          ErrorCode::kUsage,
          "a scanner gives no silhouettes: acquire.geometry is depth, or stereo for a RealSense's infrared pairs"};
    }
    if (job_.config.output.texture != TextureFormat::kOff && !request_.recording) {
      return Error{ErrorCode::kUsage,
                   "export.texture is baked from the recording: have one made, or leave the texture off"};
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
    options.camera = job_.config.acquire.camera;
    options.min_depth_m = job_.config.acquire.min_depth_m;
    options.on_recorder_failure = [this](const Error& error) {
      session_.warn(WarningCode::kRecorder, error.text() + "; the scan goes on");
      has_warned_of_recorder_ = true;
    };
    auto source = LiveSource::start(*std::move(scanner), std::move(options), recorder_.get());
    if (!source) return source.error();
    source_ = *std::move(source);
    apply_sensor(source_->info().sensor, job_.config, session_);
    is_recording_ = recorder_ != nullptr;
    has_recording_ = is_recording_;
    session_.info("scanning");
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

  /// Scans the frames as they come, until they end or are stopped; the steps after them always run.
  [[nodiscard]] PassResult scan_frames() {
    const FrameArchive archive = is_recording_ ? FrameArchive([this](std::size_t every) {
      finish_recording();
      AcquireConfig config = job_.config.acquire;
      config.every *= every;
      auto source = open_recording(*request_.recording, config);
      return source ? read_ahead(*std::move(source)) : std::move(source);
    })
                                               : FrameArchive();
    PassResult made = scan_walk(job_,
                                {.source = *source_,
                                 .archive = archive,
                                 .stop = stop_,
                                 .is_paced = true,
                                 .losses = [this] { return losses(); }},
                                session_);
    finish_recording();
    made.scan.input = std::move(result_.input);
    made.scan.losses = losses();
    warn_of_losses(*made.scan.losses, session_);
    if (has_recording_) made.scan.files["recording"] = request_.recording->string();
    return made;
  }

  /// The mesh of the tracked frames is already on disk; the mesh of the refined turntable replaces it.
  void refine_turntable(PassResult& made) {
    if (!job_.config.turntable.is_enabled || job_.config.acquire.poses == PoseMode::kStill) return;
    if (!has_recording_) {
      session_.warn(WarningCode::kTurntableNotTried,
                    "turntable: it was not looked for, because no recording was made; the mesh is the tracked one");
      return;
    }
    session_.info("finding the axis and the angles of the turntable");
    if (const auto scanned = scan_recorded_turntable(made); !scanned) {
      session_.warn(WarningCode::kTurntableNotTried,
                    fmt::format("turntable: {}; the mesh is the tracked one", scanned.error().text()));
    }
  }

  /// Makes a second pass, over the recording. If it finds a turntable, its result replaces that of the first pass.
  [[nodiscard]] Result<void> scan_recorded_turntable(PassResult& made) {
    ScanJob recorded = job_;
    recorded.input = *request_.recording;
    const auto source = open_frames(recorded, &made.taken);
    if (!source) return source.error();
    ScanSession session(session_.observer(), {});
    const FrameArchive archive = archive_of(recorded, &made.taken);
    const PassInput input{.source = **source,
                          .archive = archive,
                          .writes_tracked_mesh = false,
                          .counted = made.left_out,
                          .crop = made.crop};
    ScanResult turned = scan_turntable(recorded, input, session).scan;
    const Result<void> scanned = turned.outcome;
    if (turned.turntable->is_refined) {
      if (!scanned) turned.outcome = made.scan.outcome;
      made.scan = replacing(std::move(made.scan), std::move(turned));
    } else {
      made.scan.turntable = std::move(turned.turntable);
      if (!scanned) made.scan.turntable->reason = scanned.error().text();
    }
    made.scan.warnings = session.warnings();
    add_times(times_after_frames(session.times()), made.scan.stages);
    return scanned;
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

  ScanJob job_;  ///< its configuration is complete when the scanner is open
  const LiveScanRequest& request_;
  std::stop_token stop_;  ///< ends the frames
  ScanSession session_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<LiveSource> source_;
  bool is_recording_ = false;   ///< the recorder is still writing pictures
  bool has_recording_ = false;  ///< there is a recording, with pictures in it
  bool has_warned_of_recorder_ = false;
  ScanResult result_;
};

}  // namespace

ScanResult scan_live(const ScanJob& job, const LiveScanRequest& request, ScanObserver& observer, std::stop_token stop) {
  return LiveScan(job, request, observer, stop).run();
}

}  // namespace scanknit
