// KeptFrames: all that a DeviceSource sends, kept.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "acquire/device_source.h"

namespace scanknit::test {

class KeptFrames {
 public:
  [[nodiscard]] FrameSink frame_sink() {
    return [this](RawFrame frame) {
      const std::lock_guard lock(mutex_);
      frames_[frame.profile.kind].push_back(std::move(frame));
      changed_.notify_all();
    };
  }
  [[nodiscard]] EventSink event_sink() {
    return [this](const DeviceEvent& event) {
      const std::lock_guard lock(mutex_);
      events_.push_back(event);
      changed_.notify_all();
    };
  }

  /// What was said of the last event of that kind.
  [[nodiscard]] std::string text_of(DeviceEvent::Kind kind) {
    const std::lock_guard lock(mutex_);
    std::string text;
    for (const DeviceEvent& event : events_) {
      if (event.kind == kind) text = event.text;
    }
    return text;
  }

  /// False: it did not happen within thirty seconds.
  [[nodiscard]] bool wait_for(StreamKind kind, std::size_t count) {
    return wait([&] { return frames_[kind].size() >= count; });
  }
  [[nodiscard]] bool wait_for(DeviceEvent::Kind kind) {
    return wait([&] {
      return std::any_of(events_.begin(), events_.end(), [&](const DeviceEvent& e) { return e.kind == kind; });
    });
  }
  [[nodiscard]] std::vector<RawFrame> of(StreamKind kind) {
    const std::lock_guard lock(mutex_);
    return frames_[kind];
  }

 private:
  template <typename Condition>
  bool wait(const Condition& condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(30), condition);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<StreamKind, std::vector<RawFrame>> frames_;
  std::vector<DeviceEvent> events_;
};

}  // namespace scanknit::test
