#include "acquire/record/recorder.h"

#include <pthread.h>

#include <algorithm>
#include <condition_variable>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "acquire/record/recording_writer.h"
#include "acquire/record/ros2_recording_writer.h"

namespace scanknit {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLongestWait{400};  // a frame's in memory; well below the second that is promised
constexpr std::chrono::seconds kSyncPeriod{1};
constexpr std::int64_t kLossesPeriod_ns = 1'000'000'000;

/// Makes a lack of memory an error like a full disk, because the scan goes on without a recording.
template <typename Work>
Result<void> within_memory(const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory"};
  }
}

std::unique_ptr<RawFrameWriter> writer_for(ByteSink sink, const RawCalibration& calibration,
                                           const RecorderConfig& config) {
  if (config.ros2_streams.empty()) return std::make_unique<RecordingWriter>(std::move(sink), calibration);
  return std::make_unique<Ros2RecordingWriter>(std::move(sink), calibration, config.ros2_streams);
}

}  // namespace

Result<std::unique_ptr<Recorder>> Recorder::create(const std::filesystem::path& path, const RawCalibration& calibration,
                                                   const RecorderConfig& config) {
  auto file = AppendFile::create(path);
  if (!file) return file.error();
  std::unique_ptr<Recorder> recorder(new Recorder(*std::move(file), path, calibration, config));
  if (auto begun = recorder->writer_->begin(); !begun) {
    recorder->file_.remove();  // there is nothing in it, and it would be in the way of the next one
    return begun.error();
  }
  Recorder* self = recorder.get();
  try {
    recorder->thread_ = std::jthread([self](std::stop_token stop) { self->write_frames(std::move(stop)); });
    ::pthread_setname_np(recorder->thread_.native_handle(), "record");
    recorder->syncer_ = std::jthread([self](std::stop_token stop) { self->sync_each_second(std::move(stop)); });
    ::pthread_setname_np(recorder->syncer_.native_handle(), "record-sync");
  } catch (const std::system_error& fault) {
    recorder->thread_ = std::jthread();  // ends it
    recorder->file_.remove();
    return Error{ErrorCode::kBudget, std::string("no thread is left to record: ") + fault.what(), path.string()};
  }
  return recorder;
}

Recorder::Recorder(AppendFile file, std::filesystem::path path, const RawCalibration& calibration,
                   const RecorderConfig& config)
    : path_(std::move(path)),
      file_(std::move(file)),
      writer_(
          writer_for([this](std::span<const std::byte> bytes) { return file_.append(bytes); }, calibration, config)),
      queue_(config.queue_frames) {}

Recorder::~Recorder() {
  if (thread_.joinable()) (void)finish();
}

void Recorder::record(RawFrame frame) {
  if (has_failed_ || !queue_.try_push(std::move(frame))) ++lost_;
}

void Recorder::note_losses(const LossCounters& scanner) {
  const std::scoped_lock lock(mutex_);
  scanner_ = scanner;
}

std::optional<Error> Recorder::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

Result<RecorderSummary> Recorder::finish() {
  SCANKNIT_CHECK(thread_.joinable());
  thread_.request_stop();
  thread_.join();
  syncer_.request_stop();
  syncer_.join();
  if (frames_written_ == 0) file_.remove();
  if (const auto error = failure()) return *error;
  if (frames_written_ > 0 && !file_.is_in_place()) {
    return Error{ErrorCode::kOutput,
                 "was moved, replaced or removed while it was recorded; if it was moved, it is whole where it is now",
                 path_.string()};
  }
  return RecorderSummary{frames_written_, file_.size(), lost_};
}

void Recorder::write_frames(std::stop_token stop) {
  for (;;) {
    const auto patience =
        oldest_waiting_ ? std::max(Clock::duration{0}, *oldest_waiting_ + kLongestWait - Clock::now()) : kLongestWait;
    const auto frame = queue_.pop(stop, patience);
    if (frame) {
      write(*frame);
    } else if (stop.stop_requested()) {
      break;  // and the queue is empty
    }
    if (oldest_waiting_ && Clock::now() >= *oldest_waiting_ + kLongestWait) {
      flush();
    }
  }
  close();
}

void Recorder::write(const RawFrame& frame) {
  if (has_failed_) {
    ++lost_;
    return;
  }
  const std::uint64_t frames = writer_->frames_waiting() + 1;
  const auto written = within_memory([&] { return writer_->write(frame); });
  const bool is_flushed = writer_->frames_waiting() == 0;
  if (is_flushed || !written) {
    settle(written, frames);
  } else if (!oldest_waiting_) {
    oldest_waiting_ = Clock::now();
  }
  if (frame.host_ns >= next_losses_ns_) {
    LossCounters losses = [this] {
      const std::scoped_lock lock(mutex_);
      return scanner_;
    }();
    losses.writer += lost_;
    writer_->write_losses(frame.host_ns, losses);
    next_losses_ns_ = frame.host_ns + kLossesPeriod_ns;
  }
}

void Recorder::flush() {
  const std::uint64_t frames = writer_->frames_waiting();
  settle(within_memory([&] { return writer_->flush(); }), frames);
}

// A chunk with this many frames was written or lost.
void Recorder::settle(const Result<void>& written, std::uint64_t frames) {
  oldest_waiting_.reset();
  if (written) {
    frames_written_ += frames;
    return;
  }
  lost_ += frames;
  const std::scoped_lock lock(mutex_);
  if (!failure_) {
    const bool is_memory = written.error().code == ErrorCode::kBudget;
    failure_ = Error{is_memory ? ErrorCode::kBudget : ErrorCode::kOutput,
                     written.error().message + "; recording has stopped, the first " + std::to_string(frames_written_) +
                         " pictures are kept",
                     path_.string()};
  }
  has_failed_ = true;
}

void Recorder::close() {
  if (!has_failed_) flush();
  // After a failure too: what the last chunk did not find room for may be enough for the summary. Without one the file
  // is read as well.
  const auto finished = within_memory([&] { return writer_->finish(); });
  if (!has_failed_) settle(finished, 0);
  if (const auto synced = file_.sync(); !synced && !has_failed_) settle(synced, 0);
}

void Recorder::sync_each_second(std::stop_token stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  while (!never.wait_for(lock, stop, kSyncPeriod, [&] { return stop.stop_requested(); })) {
    if (const auto synced = file_.sync(); !synced) {
      const std::scoped_lock guard(mutex_);
      if (!failure_) failure_ = synced.error();
      has_failed_ = true;
      return;
    }
  }
}

}  // namespace scanknit
