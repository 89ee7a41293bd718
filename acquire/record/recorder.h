// Recorder: writes a scanner's frames to a file while they arrive.
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
#include <vector>

#include "acquire/mcap/append_file.h"
#include "acquire/raw_frame.h"
#include "acquire/record/raw_frame_writer.h"
#include "core/result.h"
#include "core/system/bounded_queue.h"

namespace scanknit {

struct RecorderConfig {
  std::size_t queue_frames = 128;  ///< that may wait for the disk: two seconds of two streams at 30 frames a second
  std::vector<StreamProfile> ros2_streams = {};  ///< not empty: messages of ROS 2 are written, of these streams
};

struct RecorderSummary {
  std::uint64_t frames = 0;  ///< frames in the file
  std::uint64_t bytes = 0;   ///< size of the file
  std::uint64_t lost = 0;    ///< frames that could not be written
};

/// Writes an MCAP file for `open_recording`, on its own thread named `record`. If the process is killed, the file has
/// everything older than a second; a second thread makes that survive a power cut, too. Any thread may call the
/// members; call `finish` once.
class Recorder {
 public:
  /// Errors (kOutput): the file exists already, or cannot be made.
  [[nodiscard]] static Result<std::unique_ptr<Recorder>> create(const std::filesystem::path& path,
                                                                const RawCalibration& calibration,
                                                                const RecorderConfig& config = {});
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Never waits: if the disk is too slow or full, counts the frame as lost.
  void record(RawFrame frame);

  /// Sets the scanner's losses so far; they are written once a second, together with the recorder's.
  void note_losses(const LossCounters& scanner);

  /// Frames that could not be written: LossCounters::writer.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

  /// Why recording has stopped, for example because the disk is full; nothing while it works. The file is intact up to
  /// there.
  [[nodiscard]] std::optional<Error> failure() const;

  /// Writes the waiting frames and the summary. Removes a file without a picture. Errors (kOutput): recording stopped
  /// early (the message says what the file has); the file is no longer at its path.
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
  std::unique_ptr<RawFrameWriter> writer_;
  BoundedQueue<RawFrame> queue_;
  std::atomic<std::uint64_t> lost_ = 0;
  std::atomic<bool> has_failed_ = false;
  mutable std::mutex mutex_;  // protects the next two
  std::optional<Error> failure_;
  LossCounters scanner_;

  // Only for the thread `record`.
  std::uint64_t frames_written_ = 0;
  std::int64_t next_losses_ns_ = 0;
  std::optional<std::chrono::steady_clock::time_point> oldest_waiting_;

  std::jthread syncer_;
  std::jthread thread_;
};

}  // namespace scanknit
