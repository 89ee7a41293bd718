// `record` is killed at any moment: what its camera delivered more than a second before is in the file, nothing is
// missing before it, and every picture is the one that was delivered.
#include <gtest/gtest.h>

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <list>
#include <mutex>
#include <numeric>
#include <random>
#include <thread>

#include "acquire/frame_source.h"
#include "tests/app/program.h"
#include "tests/usb/emulated/emulated_bus.h"

namespace scanknit::test {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr int kKills = 100, kAtOnce = 4;  // side by side, to save time: each has a camera and a file of its own
constexpr auto kLongestLife = 1800ms;     // from the first picture on
constexpr std::uint32_t kSeed = 5;
constexpr std::size_t kPixels = 640 * 480;

/// A wall a metre away, too rough to be written in no time; the first pixel counts pictures. In millimetres.
int depth_mm(std::uint64_t picture, std::size_t pixel) {
  const auto rough = static_cast<int>(static_cast<std::uint32_t>(pixel) * 2654435761u >> 30);
  return 1000 + (pixel == 0 ? static_cast<int>(picture) : rough);
}

/// When each picture of an emulated camera was handed over to whoever reads it: the model makes a picture as it does
/// so.
class Deliveries {
 public:
  std::vector<std::byte> deliver(std::uint64_t picture) {
    static const std::vector<std::byte> wall = [] {
      std::vector<std::byte> bytes(2 * kPixels);
      for (std::size_t i = 0; i < kPixels; ++i) put(bytes, i, depth_mm(1, i));
      return bytes;
    }();
    auto bytes = wall;
    put(bytes, 0, depth_mm(picture, 0));
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(picture, times_.size());
    times_.push_back(Clock::now());
    return bytes;
  }
  [[nodiscard]] std::optional<Clock::time_point> first() const {
    const std::lock_guard lock(mutex_);
    return times_.empty() ? std::nullopt : std::optional(times_.front());
  }
  [[nodiscard]] std::size_t before(Clock::time_point time) const {
    const std::lock_guard lock(mutex_);
    return static_cast<std::size_t>(std::lower_bound(times_.begin(), times_.end(), time) - times_.begin());
  }

 private:
  static void put(std::vector<std::byte>& bytes, std::size_t pixel, int value) {
    bytes[2 * pixel] = static_cast<std::byte>(value & 0xFF);
    bytes[2 * pixel + 1] = static_cast<std::byte>(value >> 8);
  }

  mutable std::mutex mutex_;
  std::vector<Clock::time_point> times_;
};

/// The numbers of the pictures of `file`, each of which must be what was delivered, bit by bit.
std::vector<std::size_t> pictures_in(const std::filesystem::path& file) {
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  std::vector<std::size_t> numbers;
  const auto recording = open_recording(file, config);
  if (!recording) return numbers;  // killed before the first picture was written
  while (true) {
    const FrameEvent event = (*recording)->next({});
    if (std::holds_alternative<EndOfStream>(event)) return numbers;
    const Frame* frame = std::get_if<Frame>(&event);
    if (frame == nullptr || frame->depth_m.size() != kPixels) {
      ADD_FAILURE() << "picture " << numbers.size() << " is not whole";
      return numbers;
    }
    const auto mm = [&](std::size_t pixel) { return static_cast<int>(1000 * frame->depth_m.pixels()[pixel] + 0.5F); };
    const auto number = static_cast<std::size_t>(mm(0) - depth_mm(0, 0));
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < kPixels; ++i) wrong += mm(i) != depth_mm(number, i) ? 1 : 0;
    EXPECT_EQ(wrong, 0u) << "pixels of picture " << number;
    numbers.push_back(number);
  }
}

/// A `record` with a camera of its own, to be killed `life` after its first picture.
class DoomedRecording {
 public:
  DoomedRecording(EmulatedBus& bus, const std::string& serial, const std::filesystem::path& file,
                  std::chrono::milliseconds life)
      : bus_(bus),
        file_(file),
        life_(life),
        address_(bus.plug(camera(serial))),
        program_({"record", "--device", "usb:8086:0b07/" + serial, "-o", file.string(), "--fps", "15"}) {
    bus.serve(address_, program_.process());
  }

  /// True, too, of one that ended by itself or does not begin: kill() tells.
  [[nodiscard]] bool is_over() {
    const auto first = deliveries_->first();
    return Clock::now() >= (first ? *first + life_ : born_ + 30s) || !program_.is_running();
  }
  void kill() {
    killed_ = Clock::now();
    program_.send(SIGKILL);
    const Outcome outcome = program_.wait();
    said_ = outcome.err;
    bus_.unplug(address_);
    if (has_not_begun()) return;
    EXPECT_EQ(outcome.exit_code, 128 + SIGKILL) << said_;
    EXPECT_GT(delivered(), 0u) << said_;
  }
  /// libusb had no udev: umockdev names its sockets by their descriptors, and of two processes with the same number one
  /// may find the name taken.
  [[nodiscard]] bool has_not_begun() const { return said_.find("USB cannot be used") != std::string::npos; }
  /// How many pictures must be in the file: those that came more than a second before the kill.
  [[nodiscard]] std::size_t due() const { return deliveries_->before(killed_ - 1s); }
  [[nodiscard]] std::size_t delivered() const { return deliveries_->before(Clock::time_point::max()); }
  [[nodiscard]] std::vector<std::size_t> kept() const { return pictures_in(file_); }
  /// A computer so busy that no picture came for ten periods: the driver took its transfers back, with what was in
  /// them.
  [[nodiscard]] bool was_restarted() const { return said_.find("no data for") != std::string::npos; }

 private:
  [[nodiscard]] VcamOptions camera(const std::string& serial) const {
    VcamOptions options;
    options.serial = serial;
    options.has_colour = false;
    options.depth_picture = [deliveries = deliveries_](std::uint64_t n) { return deliveries->deliver(n); };
    return options;
  }

  EmulatedBus& bus_;
  const std::shared_ptr<Deliveries> deliveries_ = std::make_shared<Deliveries>();  // the camera stays in the bus
  const std::filesystem::path file_;
  const std::chrono::milliseconds life_;
  const int address_;
  Program program_;
  const Clock::time_point born_ = Clock::now();
  Clock::time_point killed_;
  std::string said_;
};

TEST(Killed, RecordLosesAtMostItsLastSecondAt100RandomTimes) {
  EmulatedBus bus;
  TempFolder out;
  std::minstd_rand random(kSeed);
  std::list<DoomedRecording> recordings;
  constexpr int kMostNotBegun = kKills / 20;
  int started = 0, not_begun = 0, kills_with_pictures_due = 0;
  while (started < kKills + not_begun || !recordings.empty()) {
    if (started < kKills + not_begun && recordings.size() < kAtOnce) {
      const std::string name = "number" + std::to_string(started++);
      recordings.emplace_back(bus, name, out / (name + ".mcap"),
                              std::chrono::milliseconds(random() % kLongestLife.count()));
    }
    const auto over = std::ranges::find_if(recordings, &DoomedRecording::is_over);
    if (over == recordings.end()) {
      std::this_thread::sleep_for(2ms);
      continue;
    }
    over->kill();
    if (over->has_not_begun()) {
      recordings.erase(over);
      ASSERT_LE(++not_begun, kMostNotBegun);
      continue;
    }
    const std::vector<std::size_t> kept = over->kept();
    if (!over->was_restarted()) {
      std::vector<std::size_t> all(kept.size());
      std::iota(all.begin(), all.end(), 0);
      EXPECT_EQ(kept, all) << "seed " << kSeed;
      EXPECT_GE(kept.size(), over->due()) << "of " << over->delivered() << "; seed " << kSeed;
      EXPECT_LE(kept.size(), over->delivered());
      if (over->due() > 0) ++kills_with_pictures_due;
    }
    recordings.erase(over);
  }
  EXPECT_GT(kills_with_pictures_due, kKills / 4) << "else little was shown";
}

}  // namespace
}  // namespace scanknit::test
