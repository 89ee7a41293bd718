// Cameras that are unplugged and plugged in again at any moment, or cannot be started.
#include "tests/usb/emulated/live_camera.h"

namespace scanknit::test {
namespace {

constexpr std::size_t kEnough = 20;

/// At ten moments from `GetParam()` milliseconds on; the first ten are while the camera is being started.
class Unplug : public ::testing::TestWithParam<int> {};

TEST_P(Unplug, AtAnyMomentEndsCleanly) {
  for (int offset_ms = GetParam(); offset_ms < GetParam() + 10; ++offset_ms) {
    EmulatedBus bus;
    FrameLog log;
    const int address = bus.plug({.payload_bytes = offset_ms % 2 == 0 ? 0u : 65536u});
    auto source = open_first();
    ASSERT_TRUE(source);
    std::jthread hand;
    if (offset_ms < 10) hand = std::jthread([&] { bus.unplug(address); });
    const auto started =
        (*source)->start(streams_of(**source, EmulatedBus::kBriskFps), log.frame_sink(), log.event_sink());
    if (offset_ms >= 10) {
      std::this_thread::sleep_for(std::chrono::milliseconds(offset_ms - 10));
      bus.unplug(address);
    }
    EXPECT_TRUE(!started || log.wait_for(DeviceEvent::Kind::kLeft)) << offset_ms;
    const auto before = std::chrono::steady_clock::now();
    (*source)->stop();
    EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
  }
}

INSTANTIATE_TEST_SUITE_P(Ms, Unplug, ::testing::Range(0, 50, 10));

class UnpluggedCamera : public OneCamera {};

TEST_F(UnpluggedCamera, IsAnErrorToStart) {
  ASSERT_NO_FATAL_FAILURE(open());
  bus.unplug(address);
  const auto started = start(30);
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().message.find("unplugged"), std::string::npos) << started.error().message;
}

/// A camera on a bus where it comes and goes.
class Replug : public OneCamera {
 protected:
  /// Opened, it may be away for `reconnect_s` once it is started.
  void plug_in(double reconnect_s, const VcamOptions& camera = {}) {
    DeviceOptions options;
    options.reconnect_s = reconnect_s;
    open(camera, {}, options);
  }

  void begin() {
    ASSERT_TRUE(start(EmulatedBus::kBriskFps));
    EXPECT_TRUE(log.wait_for_depth(5));
  }
};

TEST_F(Replug, ResumesTheSameCameraBySerial) {
  ASSERT_NO_FATAL_FAILURE(plug_in(5, {.serial = "mine"}));
  ASSERT_NO_FATAL_FAILURE(begin());
  bus.unplug(address);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kLeft));
  bus.plug({.serial = "another"});
  bus.plug({.serial = "mine", .clock_start_us = 0});  // a second behind what it was
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kReturned));
  const std::size_t before = log.depth().size();
  EXPECT_TRUE(log.wait_for_depth(before + 10)) << "frame numbers and times go on: FrameLog looks";
}

TEST_F(Replug, SetsTheControlsAgain) {
  ASSERT_NO_FATAL_FAILURE(plug_in(20));
  ASSERT_TRUE(source->set_control(DeviceControl::kEmitter, 0));
  ASSERT_TRUE(source->set_control(DeviceControl::kLaserPower, 300));
  ASSERT_NO_FATAL_FAILURE(begin());
  bus.unplug(address);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kLeft));
  const int again = bus.plug({});
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kReturned));
  bus.with_camera(again, [](Vcam& camera) {
    EXPECT_EQ((camera.written[{0x0300, 0x0200}]), (std::vector{std::byte{0}, std::byte{0}}));
    EXPECT_EQ((camera.written[{0x0300, 0x0400}]), (std::vector{std::byte{0x2C}, std::byte{0x01}}));
  });
}

TEST_F(Replug, ResumesACameraWhosePlugWobbles) {
  ASSERT_NO_FATAL_FAILURE(plug_in(20));
  ASSERT_NO_FATAL_FAILURE(begin());
  for (const auto contact : {3ms, 8ms, 15ms, 20ms, 30ms}) {
    bus.unplug(address);
    address = bus.plug({});
    std::this_thread::sleep_for(contact);
  }
  bus.unplug(address);
  bus.plug({});
  const std::size_t before = log.depth().size();
  EXPECT_TRUE(log.wait_for_depth(before + 10));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kFailed), 0);
}

TEST_F(Replug, ThatDoesNotHappenIsGivenUp) {
  ASSERT_NO_FATAL_FAILURE(plug_in(0.2));
  ASSERT_NO_FATAL_FAILURE(begin());
  bus.unplug(address);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kFailed));
}

TEST(StartedCamera, InUseByAnotherProgramIsAnError) {
  EmulatedBus bus;
  bus.refuse_claims(bus.plug({}), true);
  const auto source = open_first();
  ASSERT_FALSE(source);
  EXPECT_EQ(source.error().code, ErrorCode::kDevice);
  EXPECT_NE(source.error().message.find("it is in use"), std::string::npos) << source.error().message;
}

TEST(StartedCamera, RefusingTheNegotiationIsAnError) {
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug({});
  const auto source = open_first();
  ASSERT_TRUE(source);
  const auto streams = streams_of(**source, 30);
  const auto start = [&](const auto& fault) {
    bus.with_camera(address, [&](Vcam& camera) { fault(camera.control_faults); });
    return (*source)->start(streams, log.frame_sink(), log.event_sink());
  };
  const auto stalls = start([](ControlFaults& faults) { faults.probe_stalls = true; });
  ASSERT_FALSE(stalls);
  EXPECT_NE(stalls.error().message.find("refused"), std::string::npos);
  const auto other = start([](ControlFaults& faults) {
    faults = {};
    faults.probe_changes_format = true;
  });
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("another picture format"), std::string::npos);
  const auto little = start([](ControlFaults& faults) {
    faults = {};
    faults.probe_bytes = 10;
  });
  ASSERT_FALSE(little);
  EXPECT_NE(little.error().message.find("10 bytes"), std::string::npos);
  EXPECT_EQ(bus.waiting_transfers(address), 0);
}

TEST(StartedCamera, AnsweringTheNegotiationOddlyStreams) {
  for (const std::size_t bytes : {26u, 34u, 48u}) {
    EmulatedBus bus;
    FrameLog log;
    const int address = bus.plug({});
    bus.with_camera(address, [&](Vcam& camera) {
      camera.control_faults.probe_bytes = bytes;
      camera.control_faults.probe_has_no_sizes = true;
    });
    const auto source = open_first();
    ASSERT_TRUE(source);
    ASSERT_TRUE((*source)->start(streams_of(**source, EmulatedBus::kBriskFps), log.frame_sink(), log.event_sink()));
    EXPECT_TRUE(log.wait_for_depth(5)) << bytes;
  }
}

TEST(StartedCamera, StreamsWithLittleUsbMemory) {
  EmulatedBus bus;
  FrameLog log;
  bus.plug({});
  bus.limit_memory(2);
  const auto source = open_first();
  ASSERT_TRUE(source);
  ASSERT_TRUE((*source)->start(streams_of(**source, EmulatedBus::kBriskFps), log.frame_sink(), log.event_sink()));
  EXPECT_TRUE(log.wait_for_depth(kEnough));
}

TEST(StartedCamera, WithoutUsbMemoryForTwoPicturesIsAnErrorWithTheRemedy) {
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug({});
  bus.with_camera(address, [](Vcam& camera) { camera.depth_faults[0] = Fault::kSilentForever; });  // none comes back
  bus.limit_memory(1);
  const auto source = open_first();
  ASSERT_TRUE(source);
  const auto started =
      (*source)->start(streams_of(**source, EmulatedBus::kBriskFps), log.frame_sink(), log.event_sink());
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().message.find("usbfs_memory_mb"), std::string::npos) << started.error().message;
}

}  // namespace
}  // namespace scanknit::test
