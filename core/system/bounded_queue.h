// BoundedQueue: the only way to pass data between threads.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "core/check.h"

namespace scanknit {

/// First in, first out; any number of threads on both sides.
template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) { SCANKNIT_CHECK(capacity > 0); }

  /// Never waits; false when the queue is full: `value` is then dropped.
  [[nodiscard]] bool try_push(T value) {
    {
      const std::scoped_lock lock(mutex_);
      if (values_.size() >= capacity_) return false;
      values_.push_back(std::move(value));
    }
    arrived_.notify_one();
    return true;
  }

  /// Takes the first value; nothing when none comes within `timeout`, or when stopped while empty.
  [[nodiscard]] std::optional<T> pop(std::stop_token stop, std::chrono::nanoseconds timeout) {
    std::unique_lock lock(mutex_);
    if (!arrived_.wait_for(lock, stop, timeout, [&] { return !values_.empty(); })) return std::nullopt;
    std::optional<T> first(std::move(values_.front()));
    values_.pop_front();
    return first;
  }

 private:
  const std::size_t capacity_;
  std::mutex mutex_;
  std::condition_variable_any arrived_;
  std::deque<T> values_;
};

}  // namespace scanknit
