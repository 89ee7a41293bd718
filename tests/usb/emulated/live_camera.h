// What the tests of the driver share: an emulated bus, and everything that comes from a camera on it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "acquire/device_source.h"
#include "tests/usb/emulated/emulated_bus.h"

namespace scanknit::test {

using namespace std::chrono_literals;

/// Every picture is checked as it arrives: whole (unless it is a JPEG), unharmed, in order.
class FrameLog {
 public:
  [[nodiscard]] FrameSink frame_sink() {
    return [this](RawFrame frame) { take(std::move(frame)); };
  }
  [[nodiscard]] EventSink event_sink() {
    return [this](const DeviceEvent& event) {
      const std::lock_guard lock(mutex_);
      events_.push_back(event);
      changed_.notify_all();
    };
  }

  /// The numbers that the emulated camera gave to the depth pictures that arrived, 0 to 4095.
  [[nodiscard]] std::vector<int> depth() const {
    const std::lock_guard lock(mutex_);
    return depth_;
  }
  [[nodiscard]] std::size_t colour_count() const {
    const std::lock_guard lock(mutex_);
    return colour_count_;
  }
  [[nodiscard]] int count(DeviceEvent::Kind kind) const {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(
        std::count_if(events_.begin(), events_.end(), [&](const DeviceEvent& event) { return event.kind == kind; }));
  }
  [[nodiscard]] std::string text_of(DeviceEvent::Kind kind) const {
    const std::lock_guard lock(mutex_);
    for (const DeviceEvent& event : events_) {
      if (event.kind == kind) return event.text;
    }
    return "";
  }
  [[nodiscard]] bool has(int number) const {
    const auto all = depth();
    return std::find(all.begin(), all.end(), number) != all.end();
  }

  /// False: it did not happen within twenty seconds.
  [[nodiscard]] bool wait_for_depth(std::size_t count) {
    return wait([&] { return depth_.size() >= count; });
  }
  [[nodiscard]] bool wait_for_colour(std::size_t count) {
    return wait([&] { return colour_count_ >= count; });
  }
  [[nodiscard]] bool wait_for(DeviceEvent::Kind kind) {
    return wait([&] {
      return std::any_of(events_.begin(), events_.end(), [&](const DeviceEvent& event) { return event.kind == kind; });
    });
  }

 private:
  template <typename Condition>
  bool wait(const Condition& condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 60s, condition);
  }

  void take(RawFrame frame) {
    const std::lock_guard lock(mutex_);
    auto& last = last_[frame.profile.kind];
    if (last.bytes) {
      EXPECT_GT(frame.sequence, last.sequence);
      EXPECT_GT(frame.device_ns, last.device_ns);
    }
    if (frame.profile.kind == StreamKind::kDepth) {
      depth_.push_back(number_of(*frame.bytes));
    } else {
      if (frame.profile.format == PixelFormat::kYuyv) (void)number_of(*frame.bytes);
      ++colour_count_;
    }
    last = std::move(frame);
    changed_.notify_all();
  }

  static int number_of(const std::vector<std::byte>& bytes) {
    const int number = std::to_integer<int>(bytes.at(0)) | std::to_integer<int>(bytes.at(1)) << 8;
    const auto expected = std::as_bytes(Vcam::depth_pixels(static_cast<std::uint64_t>(number), bytes.size() / 2));
    // memcmp, because std::equal looks at one byte at a time, which takes an emulated processor long.
    EXPECT_TRUE(bytes.size() == expected.size() && std::memcmp(bytes.data(), expected.data(), bytes.size()) == 0)
        << "a damaged picture";
    return number;
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<int> depth_;
  std::size_t colour_count_ = 0;
  std::vector<DeviceEvent> events_;
  std::map<StreamKind, RawFrame> last_;
};

/// The camera's streams of the wanted rate: depth, and colour as `format` where asked for.
inline std::vector<StreamProfile> streams_of(const DeviceSource& source, double fps,
                                             std::optional<PixelFormat> colour = {}) {
  std::vector<StreamProfile> chosen;
  for (const StreamProfile& profile : source.profiles()) {
    if (std::abs(profile.frames_per_second - fps) > 0.5) continue;
    if (profile.format == PixelFormat::kZ16 || profile.format == colour) chosen.push_back(profile);
  }
  return chosen;
}

inline Result<std::unique_ptr<DeviceSource>> open_first(const DeviceOptions& options = {}) {
  return open_camera("usb:", options, {});
}

/// One camera on a bus of its own, and all that comes from it.
class OneCamera : public ::testing::Test {
 protected:
  /// Plugs it in, as `spoil` leaves it, and opens it.
  void open(const VcamOptions& camera = {}, const std::function<void(Vcam&)>& spoil = {},
            const DeviceOptions& options = {}) {
    address = bus.plug(camera);
    if (spoil) bus.with_camera(address, spoil);
    auto opened = open_first(options);
    ASSERT_TRUE(opened) << opened.error().text();
    source = *std::move(opened);
  }

  /// Starts its streams of that rate: depth, and colour as `format` where asked for.
  [[nodiscard]] Result<void> start(double fps, std::optional<PixelFormat> format = {}) {
    return source->start(streams_of(*source, fps, format), log.frame_sink(), log.event_sink());
  }

  EmulatedBus bus;
  FrameLog log;
  std::unique_ptr<DeviceSource> source;
  int address = 0;
};

}  // namespace scanknit::test
