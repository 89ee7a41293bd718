// Recorder: keeps what a scanner sends, while it sends it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "acquire/mcap/append_file.h"
#include "acquire/raw_frame.h"
#include "acquire/record/recording_writer.h"
#include "core/bounded_queue.h"
#include "core/result.h"

namespace scanknit {

struct RecorderConfig {
  std::size_t queue_frames = 128;  ///< that wait for the disk: two seconds of two streams at 30 frames a second
};

struct RecorderSummary {
  std::uint64_t frames = 0;  ///< in the file
  std::uint64_t bytes = 0;   ///< of the file
  std::uint64_t lost = 0;    ///< frames that could not be kept
};

/// Writes a file that `open_recording` reads, on a thread of its own named `record`. Whatever happens to the process,
/// what is older than a second is in the file; a second thread makes it survive a power cut as well. All members may be
/// called from any thread, `finish` once.
class Recorder {
 public:
  /// Errors (kOutput): the file is there already, or cannot be made.
  [[nodiscard]] static Result<std::unique_ptr<Recorder>> create(const std::filesystem::path& path,
                                                                const RawCalibration& calibration,
                                                                const RecorderConfig& config = {});
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Never waits: when the disk is too slow or full, the frame is counted as lost.
  void record(RawFrame frame);

  /// What the scanner has lost so far; it is written once a second with our own losses.
  void note_losses(const LossCounters& scanner);

  /// Frames that could not be kept: LossCounters::writer.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

  /// Why recording has stopped (disk full, for instance); nothing while all is well. The file is then whole up to
  /// there.
  [[nodiscard]] std::optional<Error> failure() const;

  /// Writes what is waiting, and the summary. A file without a picture is removed. Errors (kOutput): recording stopped
  /// early, with what is in the file; the file is not where it was made.
  [[nodiscard]] Result<RecorderSummary> finish();

 private:
  Recorder(AppendFile file, std::filesystem::path path, const RawCalibration& calibration,
           const RecorderConfig& config);
  void write_frames(std::stop_token stop);
  void write(const RawFrame& frame);
  void flush();
  void close();
  void sync_each_second(std::stop_token stop);
  void settle(const Result<void>& written, std::uint64_t frames);

  std::filesystem::path path_;
  AppendFile file_;
  RecordingWriter writer_;
  BoundedQueue<RawFrame> queue_;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<bool> has_failed_ = false;
  mutable std::mutex mutex_;  // of the next two
  std::optional<Error> failure_;
  LossCounters scanner_;

  // Of the thread `record` alone.
  std::uint64_t frames_written_ = 0;
  std::int64_t next_losses_ns_ = 0;
  std::optional<std::chrono::steady_clock::time_point> oldest_waiting_;

  std::jthread syncer_;
  std::jthread thread_;
};

}  // namespace scanknit
