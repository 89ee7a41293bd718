// What goes wrong with cameras, cables and hubs: a damaged picture is never delivered, the next good one always is, and
// what was lost is counted where it was lost. FrameLog looks at every pixel of what arrives.
#include "tests/usb/emulated/live_camera.h"

namespace scanknit::test {
namespace {

constexpr int kFaultAt = 10;
constexpr std::size_t kEnough = 20;

struct PictureFault {
  const char* name;
  Fault fault;
  LossCounters losses;
  std::vector<int> missing;
  VcamOptions options = {};
};

void PrintTo(const PictureFault& fault, std::ostream* out) {
  *out << fault.name;
}

class DamagedPicture : public ::testing::TestWithParam<PictureFault> {};

TEST_P(DamagedPicture, IsCountedAndTheNextOneArrives) {
  const PictureFault& expected = GetParam();
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug(expected.options);
  bus.with_camera(address, [&](Vcam& camera) { camera.depth_faults[kFaultAt] = expected.fault; });
  const auto source = open_first();
  ASSERT_TRUE(source) << source.error().text();
  const auto streams = streams_of(**source, expected.options.is_isochronous ? 30 : EmulatedBus::kBriskFps);
  ASSERT_TRUE((*source)->start(streams, log.frame_sink(), log.event_sink()));
  EXPECT_TRUE(log.wait_for_depth(kEnough));
  (*source)->stop();
  std::vector<int> missing;
  const auto numbers = log.depth();
  for (int number = 0; number <= numbers.back(); ++number) {
    if (!log.has(number)) missing.push_back(number);
  }
  EXPECT_EQ(missing, expected.missing);
  const LossCounters losses = (*source)->losses();
  EXPECT_EQ(losses.device, expected.losses.device);
  EXPECT_EQ(losses.transport, expected.losses.transport);
  EXPECT_EQ(losses.overflow, expected.losses.overflow);
  EXPECT_EQ(log.count(DeviceEvent::Kind::kFailed), 0);
}

constexpr LossCounters kNone{}, kDevice{1, 0, 0, 0, 0}, kTransport{0, 1, 0, 0, 0}, kOverflow{0, 0, 1, 0, 0};
// The picture ends too early, and nothing tells what then comes of it from the remains of another one.
constexpr LossCounters kTwoRemains{0, 2, 0, 0, 0};
const VcamOptions kSmallPayloads{.payload_bytes = 65536};
const VcamOptions kIsochronous{.is_isochronous = true, .speed_mbit = 480};

INSTANTIATE_TEST_SUITE_P(
    All, DamagedPicture,
    ::testing::Values(PictureFault{"Truncated", Fault::kTruncated, kTransport, {10}},
                      PictureFault{"Oversize", Fault::kOversize, kOverflow, {10}},
                      PictureFault{"HeaderLength0", Fault::kHeaderLength0, kTransport, {10}},
                      PictureFault{"HeaderLength1", Fault::kHeaderLength1, kTransport, {10}},
                      PictureFault{"HeaderTooLong", Fault::kHeaderTooLong, kTransport, {10}},
                      PictureFault{"ErrorBit", Fault::kErrorBit, kTransport, {10}},
                      PictureFault{"SameFrameId", Fault::kSameFrameId, kNone, {}},
                      PictureFault{"MissingEnd", Fault::kMissingEnd, kNone, {}},
                      PictureFault{"HeaderOnly", Fault::kHeaderOnly, kDevice, {10}},
                      PictureFault{"Babble", Fault::kBabble, kOverflow, {10}},
                      PictureFault{"IoError", Fault::kIoError, kTransport, {10}},
                      PictureFault{"Eio", Fault::kEio, kTransport, {10}},
                      PictureFault{"Skipped", Fault::kSkipped, kDevice, {10}},
                      PictureFault{"SentTwice", Fault::kSentTwice, kTransport, {}},
                      PictureFault{"ClockBack", Fault::kClockBack, kNone, {}},
                      PictureFault{"ClockAhead", Fault::kClockAhead, kNone, {}},
                      PictureFault{"TruncatedInPieces", Fault::kTruncated, kTransport, {10}, kSmallPayloads},
                      PictureFault{"OversizeInPieces", Fault::kOversize, kOverflow, {10}, kSmallPayloads},
                      PictureFault{"HeaderLength0InPieces", Fault::kHeaderLength0, kTransport, {10}, kSmallPayloads},
                      PictureFault{"ErrorBitInPieces", Fault::kErrorBit, kTransport, {10}, kSmallPayloads},
                      PictureFault{"MissingEndInPieces", Fault::kMissingEnd, kNone, {}, kSmallPayloads},
                      PictureFault{"SameFrameIdInPieces", Fault::kSameFrameId, kNone, {}, kSmallPayloads},
                      PictureFault{"BabbleInPieces", Fault::kBabble, kOverflow, {10}, kSmallPayloads},
                      PictureFault{"IoErrorInPieces", Fault::kIoError, kTransport, {10}, kSmallPayloads},
                      PictureFault{"EioInPieces", Fault::kEio, kTransport, {10}, kSmallPayloads},
                      PictureFault{"SentTwiceInPieces", Fault::kSentTwice, kTransport, {}, kSmallPayloads},
                      PictureFault{"ShortPayload", Fault::kShortPayload, kTransport, {10}, kSmallPayloads},
                      PictureFault{"LongPayload", Fault::kLongPayload, kTransport, {10}, kSmallPayloads},
                      PictureFault{"RepeatedPayload", Fault::kRepeatedPayload, kOverflow, {10}, kSmallPayloads},
                      PictureFault{"Reordered", Fault::kReordered, kTwoRemains, {10}, kSmallPayloads},
                      PictureFault{"ReorderedPackets", Fault::kReordered, kTwoRemains, {10}, kIsochronous},
                      PictureFault{"RepeatedPacket", Fault::kRepeatedPayload, kOverflow, {10}, kIsochronous},
                      PictureFault{"GarbledPacket", Fault::kGarbledPacket, kTransport, {10}, kIsochronous},
                      PictureFault{"EioPacket", Fault::kEio, kTransport, {10}, kIsochronous},
                      PictureFault{"LostPacket", Fault::kLostPacket, kTransport, {10}, kIsochronous},
                      PictureFault{"ErrorBitInPackets", Fault::kErrorBit, kTransport, {10}, kIsochronous},
                      PictureFault{"MissingEndInPackets", Fault::kMissingEnd, kNone, {}, kIsochronous}),
    [](const auto& test) { return test.param.name; });

/// A camera at 90 frames a second with one fault at picture 10.
class FaultyCamera : public OneCamera {
 protected:
  void begin(Fault fault, const VcamOptions& options = {}) {
    begin_as([&](Vcam& camera) { camera.depth_faults[kFaultAt] = fault; }, options);
  }
  void begin_as(const std::function<void(Vcam&)>& spoil, const VcamOptions& options = {},
                const DeviceOptions& device = {}) {
    ASSERT_NO_FATAL_FAILURE(open(options, spoil, device));
    ASSERT_TRUE(start(options.is_isochronous ? 30 : EmulatedBus::kBriskFps));
  }
};

TEST_F(FaultyCamera, ThatStallsOnceGoesOn) {
  begin(Fault::kStall);
  EXPECT_TRUE(log.wait_for_depth(kEnough));
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kRecovered));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kStalled), 1);
  bus.with_camera(address, [](Vcam& camera) { EXPECT_EQ(camera.halts_cleared, 1); });
  EXPECT_TRUE(log.has(kFaultAt + 1)) << "the first picture after the stall";
  EXPECT_EQ(source->losses().total(), 1u);
}

TEST_F(FaultyCamera, ThatStallsAgainAndAgainIsGivenUpWithWords) {
  begin(Fault::kStallForever);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kFailed));
  EXPECT_NE(log.text_of(DeviceEvent::Kind::kFailed).find("Re-plug it"), std::string::npos);
  EXPECT_EQ(log.depth().size(), 10u);
  EXPECT_EQ(bus.waiting_transfers(address), 0);
}

TEST_F(FaultyCamera, WhoseTransfersFailForAWhileIsStartedAgain) {
  DeviceOptions device;
  device.silence_s = 5;  // on a busy computer nine failures may take longer than the default
  begin_as([](Vcam& camera) { camera.lasting_fault = {Fault::kEio, kFaultAt, 2}; }, {}, device);
  EXPECT_TRUE(log.wait_for_depth(kEnough));
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kRecovered));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kFailed), 0);
  EXPECT_GE(source->losses().transport, 9u) << "so many in a row are too many";
}

TEST_F(FaultyCamera, WhoseTransfersFailForEverIsGivenUpWithWords) {
  begin_as([](Vcam& camera) { camera.lasting_fault = {Fault::kEio, kFaultAt}; });
  ASSERT_TRUE(log.wait_for(DeviceEvent::Kind::kFailed));
  EXPECT_NE(log.text_of(DeviceEvent::Kind::kFailed).find("Re-plug it"), std::string::npos)
      << log.text_of(DeviceEvent::Kind::kFailed);
  EXPECT_EQ(log.depth().size(), std::size_t{kFaultAt});
  EXPECT_EQ(bus.waiting_transfers(address), 0);
}

TEST_F(FaultyCamera, ThatFallsSilentIsStartedAgain) {
  begin(Fault::kSilent);
  EXPECT_TRUE(log.wait_for_depth(kEnough));
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kRecovered));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kSilent), 1);
  EXPECT_NE(log.text_of(DeviceEvent::Kind::kSilent).find("no data for "), std::string::npos);
  bus.with_camera(address, [](Vcam& camera) { EXPECT_EQ(camera.commits, 2); });
}

TEST_F(FaultyCamera, ThatStaysSilentIsGivenUpWithWords) {
  begin(Fault::kSilentForever);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kFailed));
  EXPECT_NE(log.text_of(DeviceEvent::Kind::kFailed).find("USB 3 link"), std::string::npos);
}

TEST_F(FaultyCamera, ThatSendsDamagedPicturesOnlyIsStartedAgain) {
  begin_as([](Vcam& camera) { camera.lasting_fault = {Fault::kErrorBit, kFaultAt, 3}; });
  EXPECT_TRUE(log.wait_for_depth(kEnough));
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kRecovered));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kFailed), 0);
  bus.with_camera(address, [](Vcam& camera) { EXPECT_GE(camera.commits, 3); });
}

/// Bulk and isochronous cameras, all of whose pictures are spoilt.
struct LastingDamage {
  const char* name;
  Fault fault;
  const char* words;
  VcamOptions options = {};
};

void PrintTo(const LastingDamage& damage, std::ostream* out) {
  *out << damage.name;
}

class CameraOfDamagedPictures : public FaultyCamera, public ::testing::WithParamInterface<LastingDamage> {};

TEST_P(CameraOfDamagedPictures, IsGivenUpWithWordsAndCounts) {
  begin_as([](Vcam& camera) { camera.lasting_fault = {GetParam().fault, kFaultAt}; }, GetParam().options);
  ASSERT_TRUE(log.wait_for(DeviceEvent::Kind::kFailed));
  const std::string text = log.text_of(DeviceEvent::Kind::kFailed);
  EXPECT_NE(text.find("all are damaged"), std::string::npos) << text;
  EXPECT_NE(text.find("Check the cable, the hub and its power"), std::string::npos) << text;
  EXPECT_NE(text.find(GetParam().words), std::string::npos) << text;
  EXPECT_GE(source->losses().transport + source->losses().overflow, 10u);
  EXPECT_EQ(log.depth().size(), std::size_t{kFaultAt});
  EXPECT_EQ(bus.waiting_transfers(address), 0);
}

INSTANTIATE_TEST_SUITE_P(
    All, CameraOfDamagedPictures,
    ::testing::Values(LastingDamage{"ErrorBit", Fault::kErrorBit, "0 too long"},
                      LastingDamage{"Truncated", Fault::kTruncated, "0 too long"},
                      LastingDamage{"Oversize", Fault::kOversize, " incomplete"},
                      LastingDamage{"TruncatedInPieces", Fault::kTruncated, "0 too long", kSmallPayloads},
                      LastingDamage{"ErrorBitInPackets", Fault::kErrorBit, "0 too long", kIsochronous}),
    [](const auto& test) { return test.param.name; });

TEST_F(FaultyCamera, OfTheIsochronousKindIsStartedAgainToo) {
  begin(Fault::kSilent, kIsochronous);
  EXPECT_TRUE(log.wait_for_depth(13));
}

/// A camera whose depth is as it should be, and colour is not. Two streams are a lot for a program with instruments:
/// few pictures, 15 a second.
class FaultyColour : public FaultyCamera {
 protected:
  static constexpr std::size_t kGoodAtFirst = 3;
  void begin_with(Fault fault, const VcamOptions& options = {}) {
    ASSERT_NO_FATAL_FAILURE(open(options, [&](Vcam& camera) { camera.colour_faults[kGoodAtFirst] = fault; }));
    ASSERT_TRUE(start(15, PixelFormat::kYuyv));
  }
};

TEST_F(FaultyColour, ThatIsDamagedOnceIsCountedAndGoesOn) {
  begin_with(Fault::kErrorBit);
  EXPECT_TRUE(log.wait_for_colour(2 * kGoodAtFirst));
  source->stop();
  EXPECT_EQ(source->losses(), (LossCounters{0, 1, 0, 0, 0}));
}

TEST_F(FaultyColour, ThatStallsOnceGoesOn) {
  begin_with(Fault::kStall);
  EXPECT_TRUE(log.wait_for_colour(2 * kGoodAtFirst));
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kRecovered));
  EXPECT_NE(log.text_of(DeviceEvent::Kind::kStalled).find("colour stopped"), std::string::npos);
}

/// Where depth is bulk, and where it is isochronous, too.
class IsochronousColour : public FaultyColour, public ::testing::WithParamInterface<bool> {
 protected:
  const VcamOptions options{.is_isochronous = GetParam(), .has_isochronous_colour = true, .speed_mbit = 480};
};

TEST_P(IsochronousColour, WithAPacketLostIsCountedAndDepthIsWhole) {
  begin_with(Fault::kLostPacket, options);
  EXPECT_TRUE(log.wait_for_colour(2 * kGoodAtFirst));
  EXPECT_TRUE(log.wait_for_depth(2 * kGoodAtFirst + 1));
  source->stop();
  EXPECT_EQ(source->losses(), (LossCounters{0, 1, 0, 0, 0}));
  for (int number = 0; number < log.depth().back(); ++number) EXPECT_TRUE(log.has(number)) << number;
  EXPECT_EQ(bus.waiting_transfers(address), 0);
}

TEST_P(IsochronousColour, ThatFallsSilentIsStartedAgain) {
  begin_with(Fault::kSilent, options);
  EXPECT_TRUE(log.wait_for_colour(2 * kGoodAtFirst));
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kRecovered));
  EXPECT_NE(log.text_of(DeviceEvent::Kind::kSilent).find("no colour for "), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Depth, IsochronousColour, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "Isochronous" : "Bulk"; });

class LastingFaultOfColour : public FaultyColour, public ::testing::WithParamInterface<Fault> {};

TEST_P(LastingFaultOfColour, LeavesDepthAlone) {
  begin_with(GetParam());
  ASSERT_TRUE(log.wait_for(DeviceEvent::Kind::kNoColour));
  const std::string text = log.text_of(DeviceEvent::Kind::kNoColour);
  EXPECT_NE(text.find("goes on without colour"), std::string::npos) << text;
  const std::size_t so_far = log.depth().size();
  EXPECT_TRUE(log.wait_for_depth(so_far + 10));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kFailed), 0);
  EXPECT_LE(log.colour_count(), kGoodAtFirst);
  source->stop();
  EXPECT_EQ(bus.waiting_transfers(address), 0);
}

INSTANTIATE_TEST_SUITE_P(All, LastingFaultOfColour, ::testing::Values(Fault::kStallForever, Fault::kSilentForever),
                         [](const auto& test) { return test.param == Fault::kStallForever ? "Stall" : "Silence"; });

TEST_F(FaultyCamera, WhoseClockJumpsIsToldOf) {
  begin(Fault::kClockBack);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kClockJump));
}

TEST_F(FaultyCamera, WhoseClockStandsStillStreams) {
  begin(Fault::kSkipped);
  bus.with_camera(address, [](Vcam& camera) { camera.clock_is_frozen = true; });
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kClockJump));
  EXPECT_TRUE(log.wait_for_depth(kEnough));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kClockJump), 1);
}

TEST_F(FaultyCamera, WhoseClockWrapsIsFollowed) {
  // The model's clock runs with this computer's from where it is told to start: just before 2^32 us.
  const auto now_us = std::chrono::steady_clock::now().time_since_epoch() / 1us;
  const auto start = static_cast<std::uint32_t>(0xFFFFFFFFll - now_us - 100'000);
  begin(Fault::kSkipped, {.clock_start_us = start});
  EXPECT_TRUE(log.wait_for_depth(40));
  EXPECT_EQ(log.count(DeviceEvent::Kind::kClockJump), 0);
}

void fall_mute(Vcam& camera) {
  camera.control_faults.is_mute = true;
}

class MuteCamera : public FaultyCamera, public ::testing::WithParamInterface<bool> {};

TEST_P(MuteCamera, IsStoppedWithinASecond) {
  begin(Fault::kSkipped, GetParam() ? kIsochronous : VcamOptions{});
  EXPECT_TRUE(log.wait_for_depth(5));
  bus.with_camera(address, fall_mute);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kSilent)) << "it is being started again now";
  const auto before = std::chrono::steady_clock::now();
  source->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
  EXPECT_EQ(bus.waiting_transfers(address), 0);
}

INSTANTIATE_TEST_SUITE_P(All, MuteCamera, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "Isochronous" : "Bulk"; });

TEST(OpenedCamera, ThatAnswersNothingIsNotWaitedForAfterAStop) {
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug({});
  std::stop_source stop;
  const auto source = open_camera("usb:", {}, stop.get_token());
  ASSERT_TRUE(source);
  bus.with_camera(address, fall_mute);
  const std::jthread hand([&] {
    std::this_thread::sleep_for(100ms);
    stop.request_stop();
  });
  const auto before = std::chrono::steady_clock::now();
  const auto streams = streams_of(**source, 30);
  (void)(*source)->calibration(streams);
  EXPECT_FALSE((*source)->start(streams, log.frame_sink(), log.event_sink()));
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1100ms);
}

TEST_F(FaultyCamera, ThatIsUnpluggedEndsCleanly) {
  begin(Fault::kSkipped);
  EXPECT_TRUE(log.wait_for_depth(5));
  bus.unplug(address);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kLeft));
  const auto before = std::chrono::steady_clock::now();
  source->stop();
  source.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
}

TEST_F(FaultyCamera, ThatIsUnpluggedWhileItsHaltIsClearedEndsCleanly) {
  begin(Fault::kStallForever);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kStalled));
  bus.unplug(address);
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kLeft));
}

TEST(SlowConsumer, LosesWholePicturesThatAreCounted) {
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug({.waits_for_computer = false});
  // However busy the machine is, the first picture is made when transfers wait for it.
  bus.with_camera(address, [](Vcam& camera) { camera.depth_waits_at = 0; });
  const auto source = open_first();
  ASSERT_TRUE(source);
  auto sink = log.frame_sink();
  const auto slow_sink = [&](RawFrame frame) {
    if (frame.sequence == 5) std::this_thread::sleep_for(400ms);  // longer than the transfers on their way last
    sink(std::move(frame));
  };
  ASSERT_TRUE((*source)->start(streams_of(**source, EmulatedBus::kBriskFps), slow_sink, log.event_sink()));
  bus.with_camera(address, [](Vcam& camera) { camera.depth_waits_at = Vcam::kNever; });
  EXPECT_TRUE(log.wait_for_depth(40));
  (*source)->stop();
  const auto numbers = log.depth();
  const LossCounters losses = (*source)->losses();
  EXPECT_GT(losses.device, 0u);
  EXPECT_EQ(losses.total(), static_cast<std::uint64_t>(numbers.back() + 1) - numbers.size());
}

}  // namespace
}  // namespace scanknit::test
