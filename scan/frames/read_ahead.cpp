#include "scan/frames/read_ahead.h"

#include <system_error>
#include <utility>
#include <variant>

#include "core/system/beside.h"

namespace scanknit {

ReadAhead::ReadAhead(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {
  try {
    reader_ = std::jthread([this](const std::stop_token& reader_stop) { read(reader_stop); });
  } catch (const std::system_error&) {  // the system has no thread left: next() reads
  }
}

FrameEvent ReadAhead::next(std::stop_token stop) {
  if (!reader_.joinable()) return source_->next(stop);
  std::unique_lock lock(mutex_);
  has_changed_.wait(lock, stop, [this] { return !events_.empty() || is_over_; });
  if (stop.stop_requested()) return EndOfStream{};
  if (events_.empty()) {
    if (failure_) std::rethrow_exception(failure_);
    return EndOfStream{};
  }
  FrameEvent event = std::move(events_.front());
  events_.pop_front();
  has_changed_.notify_all();
  return event;
}

void ReadAhead::read(const std::stop_token& stop) {
  bool goes_on = true;
  while (goes_on) goes_on = read_one(stop);
}

/// False after the last event.
bool ReadAhead::read_one(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (!has_changed_.wait(lock, stop, [this] { return events_.size() < kFramesAhead; })) return false;
  lock.unlock();
  std::exception_ptr failure;
  FrameEvent event;
  try {
    event = source_->next(stop);
  } catch (...) {
    failure = std::current_exception();
  }
  const bool is_end = failure || std::holds_alternative<EndOfStream>(event);
  const bool is_last = is_end || std::holds_alternative<Error>(event);
  lock.lock();
  if (!is_end) events_.push_back(std::move(event));
  failure_ = failure;
  is_over_ = is_last;
  has_changed_.notify_all();
  return !is_last;
}

std::unique_ptr<FrameSource> read_ahead(std::unique_ptr<FrameSource> source) {
  if (!may_work_beside()) return source;
  return std::make_unique<ReadAhead>(std::move(source));
}

}  // namespace scanknit
