// LiveSource: a source of frames from a streaming scanner.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "acquire/device_source.h"
#include "acquire/frame_source.h"
#include "acquire/record/recorder.h"
#include "acquire/replay/frame_pairing.h"
#include "acquire/sensor/depth_bias.h"
#include "core/limits.h"
#include "core/system/bounded_queue.h"

namespace scanknit {

class PairDepth;

/// The streams of a scanner, and their calibration.
struct LiveScanner {
  std::unique_ptr<DeviceSource> device;
  std::vector<StreamProfile> streams;
  RawCalibration calibration;
};

struct LiveOptions {
  PoseMode poses = PoseMode::kTrack;  ///< kTrack or kStill
  std::optional<std::size_t> frames;  ///< ends after so many depth pictures
  std::optional<double> seconds;      ///< ends so long after the first picture
  bool survives_unplugging = true;    ///< the device reconnects (DeviceOptions::reconnect_s) or fails by itself
  std::shared_ptr<const ScannerCamera> camera = nullptr;  ///< AcquireConfig::camera; recordings keep the scanner's own
  std::optional<double> min_depth_m = {};                 ///< the nearest depth that is looked for in pairs of pictures
  bool matches_pairs = true;                              ///< else pairs are only recorded, and count as dropped frames
  EventSink on_event;                                     ///< next() calls it, not a thread of the scanner
  /// Called once in the same way when the recorder has stopped; frames still come.
  std::function<void(const Error&)> on_recorder_failure = {};
};

/// next() gives the newest frame and drops those that came before it in the meantime (DropReason::kQueue), so that the
/// view and tracking show what the scanner sees now. The recorder gets all frames.
class LiveSource final : public FrameSource {
 public:
  /// Starts the scanner. `recorder` may be null and outlives this. Errors: it cannot be started (kDevice);
  /// override_calibration()'s; of pairs of pictures PairDepth::create()'s.
  [[nodiscard]] static Result<std::unique_ptr<LiveSource>> start(LiveScanner scanner, LiveOptions options,
                                                                 Recorder* recorder);
  ~LiveSource() override;

  [[nodiscard]] const RecordingInfo& info() const override { return info_; }

  /// Ends when stopped, at the limits of LiveOptions, and when the scanner has failed; the scanner is then stopped.
  [[nodiscard]] FrameEvent next(std::stop_token stop) override;
  [[nodiscard]] bool wait(std::stop_token stop, std::chrono::milliseconds patience) override;

  /// Why the scanner sends no more frames; nothing while it does.
  [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

  /// The losses of all streams since the start, without those of the recorder.
  [[nodiscard]] LossCounters losses() const;

 private:
  LiveSource(LiveScanner scanner, LiveOptions options, Recorder* recorder, std::unique_ptr<PairDepth> pairs);
  void take(RawFrame frame);
  void report_events();
  void report_losses();
  void report_recorder_failure();
  [[nodiscard]] bool is_over() const;
  [[nodiscard]] bool has_ended(const std::stop_token& stop) const;
  [[nodiscard]] std::optional<RawPair> newest_pair();
  [[nodiscard]] FrameEvent decode(const RawPair& pair);

  bool has_colour_stream_;
  std::unique_ptr<PairDepth> pairs_;  ///< null: the scanner sends depth
  RecordingInfo info_;
  LiveOptions options_;
  Recorder* recorder_;
  RawCalibration calibration_;
  Limits limits_;
  std::optional<DepthCorrection> correction_;

  // Shared with the scanner's threads.
  BoundedQueue<RawFrame> queue_;
  std::atomic<std::uint64_t> lost_in_queue_ = 0;
  std::size_t depth_taken_ = 0;  // only the scanner's threads use it, one at a time
  std::mutex events_mutex_;
  std::vector<DeviceEvent> events_;

  FramePairing pairing_;
  std::deque<FrameDropped> skipped_;
  std::optional<RawPair> ready_;  ///< came while wait() was waiting
  std::size_t pictures_ = 0;
  std::optional<std::chrono::steady_clock::time_point> first_at_;
  std::chrono::steady_clock::time_point losses_at_{};
  bool has_reported_recorder_failure_ = false;
  std::optional<std::int64_t> last_timestamp_ns_;
  std::optional<Error> failure_;

  std::unique_ptr<DeviceSource> device_;  // declared last, because its threads use the other members
};

}  // namespace scanknit
