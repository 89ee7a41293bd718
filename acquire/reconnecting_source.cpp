#include "acquire/reconnecting_source.h"

#include <algorithm>
#include <array>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "acquire/waiting.h"

namespace scanknit {
namespace {

class ReconnectingSource final : public DeviceSource {
 public:
  ReconnectingSource(std::unique_ptr<DeviceSource> source, ReopenDevice reopen, std::chrono::milliseconds patience)
      : source_(std::move(source)), info_(source_->info()), reopen_(std::move(reopen)), patience_(patience) {}
  ~ReconnectingSource() override { stop(); }

  [[nodiscard]] const DeviceInfo& info() const override { return info_; }
  [[nodiscard]] std::vector<StreamProfile> profiles() const override {
    const std::lock_guard lock(mutex_);
    return source_ ? source_->profiles() : std::vector<StreamProfile>{};
  }
  [[nodiscard]] Result<RawCalibration> calibration(std::span<const StreamProfile> streams) override {
    const std::lock_guard lock(mutex_);
    return source_ ? source_->calibration(streams) : Result<RawCalibration>(absent());
  }
  [[nodiscard]] Result<void> set_control(DeviceControl control, int value) override {
    const std::lock_guard lock(mutex_);
    auto done = source_ ? source_->set_control(control, value) : Result<void>(absent());
    if (done) controls_[control] = value;
    return done;
  }
  [[nodiscard]] LossCounters losses() const override {
    const std::lock_guard lock(mutex_);
    LossCounters losses = losses_before_;
    if (source_) losses += source_->losses();
    return losses;
  }
  [[nodiscard]] Result<void> start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) override;
  void stop() override;

 private:
  [[nodiscard]] Error absent() const { return {ErrorCode::kDevice, "unplugged", info_.name}; }
  [[nodiscard]] Result<void> start_source(DeviceSource& source);
  void on_frame(RawFrame frame);
  void on_event(const DeviceEvent& event);
  void wait_and_reopen(const std::stop_token& stop);
  [[nodiscard]] Result<std::unique_ptr<DeviceSource>> reopen(const std::stop_token& give_up);

  std::unique_ptr<DeviceSource> source_;  // none: unplugged
  const DeviceInfo info_;
  const ReopenDevice reopen_;
  const std::chrono::milliseconds patience_;
  std::vector<StreamProfile> streams_;
  FrameSink frames_;
  EventSink events_;
  // By stream kind; only the source's frame thread touches them, and the next source's once that one has ended.
  std::array<std::uint64_t, 2> first_sequence_{}, next_sequence_{};
  // The camera's clock begins anew when it is plugged in; its streams share it, and so they share the offset.
  std::int64_t device_offset_ns_ = 0, last_device_ns_ = 0, last_host_ns_ = 0;
  bool is_new_clock_ = false;
  mutable std::mutex mutex_;               // of source_, losses_before_, has_left_, controls_
  std::map<DeviceControl, int> controls_;  // a camera forgets them when it is unplugged
  std::condition_variable_any left_;
  bool has_left_ = false;
  LossCounters losses_before_;
  std::jthread reopener_;
};

Result<void> ReconnectingSource::start(std::span<const StreamProfile> streams, FrameSink frames, EventSink events) {
  const std::lock_guard lock(mutex_);
  if (!source_) return absent();
  streams_.assign(streams.begin(), streams.end());
  frames_ = std::move(frames);
  events_ = std::move(events);
  first_sequence_ = next_sequence_ = {};
  device_offset_ns_ = 0;
  is_new_clock_ = false;
  losses_before_ = {};
  has_left_ = false;
  if (const auto started = start_source(*source_); !started) return started.error();
  reopener_ = std::jthread([this](const std::stop_token& stop) { wait_and_reopen(stop); });
  return {};
}

Result<void> ReconnectingSource::start_source(DeviceSource& source) {
  return source.start(
      streams_, [this](RawFrame frame) { on_frame(std::move(frame)); },
      [this](const DeviceEvent& event) { on_event(event); });
}

void ReconnectingSource::stop() {
  if (reopener_.joinable()) {
    reopener_.request_stop();
    reopener_.join();
  }
  if (source_) source_->stop();
}

void ReconnectingSource::on_frame(RawFrame frame) {
  const auto kind = static_cast<std::size_t>(frame.profile.kind);
  frame.sequence += first_sequence_[kind];
  next_sequence_[kind] = frame.sequence + 1;
  if (std::exchange(is_new_clock_, false)) {
    device_offset_ns_ = last_device_ns_ + (frame.host_ns - last_host_ns_) - frame.device_ns;
  }
  frame.device_ns += device_offset_ns_;
  last_device_ns_ = frame.device_ns;
  last_host_ns_ = frame.host_ns;
  frames_(std::move(frame));
}

void ReconnectingSource::on_event(const DeviceEvent& event) {
  events_(event);
  if (event.kind != DeviceEvent::Kind::kLeft) return;
  {
    const std::lock_guard lock(mutex_);
    has_left_ = true;
  }
  left_.notify_all();
}

void ReconnectingSource::wait_and_reopen(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::unique_ptr<DeviceSource> old;
    {
      std::unique_lock lock(mutex_);
      if (!left_.wait(lock, stop, [this] { return has_left_; })) return;
      has_left_ = false;
      losses_before_ += source_->losses();
      old = std::move(source_);
    }
    old.reset();  // waits for its threads: not under the lock, which its last event may want
    std::stop_source give_up;
    const std::stop_callback on_stop(stop, [&] { give_up.request_stop(); });
    const std::jthread alarm([&](const std::stop_token& found) {
      if (pause(patience_, found)) give_up.request_stop();
    });
    auto reopened = reopen(give_up.get_token());
    if (stop.stop_requested()) return;
    if (!reopened) {
      events_({DeviceEvent::Kind::kFailed, info_.name + " did not come back: " + reopened.error().text()});
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      source_ = std::move(*reopened);
    }
    events_({DeviceEvent::Kind::kReturned, info_.name + ": plugged in again"});
  }
}

/// A plug that wobbles comes and goes, and what has just come may not be ready: only `give_up` ends the attempts.
Result<std::unique_ptr<DeviceSource>> ReconnectingSource::reopen(const std::stop_token& give_up) {
  constexpr std::chrono::milliseconds kPause(100);
  while (true) {
    Result<void> started;
    auto reopened = reopen_(give_up);
    if (reopened) {
      first_sequence_ = next_sequence_;
      is_new_clock_ = true;
      {
        const std::lock_guard lock(mutex_);
        has_left_ = false;  // the one before may have left while it started
        for (const auto& [control, value] : controls_) (void)(*reopened)->set_control(control, value);
      }
      started = start_source(**reopened);
      if (started) return reopened;
    }
    const Error error = reopened ? started.error() : reopened.error();
    reopened = error;  // gone before the next attempt
    if (!pause(kPause, give_up)) return error;
  }
}

}  // namespace

std::unique_ptr<DeviceSource> make_reconnecting(std::unique_ptr<DeviceSource> source, ReopenDevice reopen,
                                                std::chrono::milliseconds patience) {
  return std::make_unique<ReconnectingSource>(std::move(source), std::move(reopen), patience);
}

}  // namespace scanknit
