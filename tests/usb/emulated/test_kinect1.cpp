// A first Kinect through an unmodified libfreenect.
#include <cmath>

#include "tests/acquire/kept_frames.h"
#include "tests/usb/emulated/live_camera.h"
#include "tests/usb/vcam/vkinect.h"

namespace scanknit::test {
namespace {

/// The share of pixels that have exactly `value`.
double share_of(const RawFrame& frame, std::uint16_t value) {
  std::vector<std::uint16_t> pixels(frame.bytes->size() / 2);
  std::memcpy(pixels.data(), frame.bytes->data(), 2 * pixels.size());
  const auto count = std::count(pixels.begin(), pixels.end(), value);
  return static_cast<double>(count) / static_cast<double>(pixels.size());
}

/// What the geometry of the model says of a disparity: fixed_x = (raw - 4 * 200) / 4 - 0.375 pixels of 0.1042 cm at
/// 120 cm, emitter at 7.5 cm.
std::uint16_t depth_mm_of(int raw) {
  const double x_cm = ((raw - 4 * 200.0) / 4 - 0.375) * 0.1042;
  return static_cast<std::uint16_t>(10 * (x_cm * 120 / (7.5 - x_cm) + 120));
}

TEST(EmulatedKinect, IsListed) {
  EmulatedBus bus;
  bus.plug_model(std::make_unique<VKinect>());
  const auto cameras = list_cameras();
  ASSERT_TRUE(cameras);
  ASSERT_EQ(cameras->size(), 1u);
  EXPECT_EQ(cameras->front().uri, "kinect1:A00000000000000A");
  EXPECT_EQ(cameras->front().serial, "A00000000000000A");
}

TEST(EmulatedKinect, StreamsDepthInMillimetresAndColour) {
  EmulatedBus bus;
  KeptFrames frames;
  bus.plug_model(std::make_unique<VKinect>());
  const auto source = open_camera("kinect1:0", {}, {});
  ASSERT_TRUE(source) << source.error().text();
  const auto streams = (*source)->profiles();
  ASSERT_TRUE((*source)->start(streams, frames.frame_sink(), frames.event_sink()));
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, 10));
  EXPECT_TRUE(frames.wait_for(StreamKind::kColour, 10));
  const auto before = std::chrono::steady_clock::now();
  (*source)->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 10s) << "the wait is bounded";
  // The Kinect streams before libfreenect listens: what that costs is not ours to say. Afterwards none is lost.
  for (const StreamKind kind : {StreamKind::kDepth, StreamKind::kColour}) {
    const auto all = frames.of(kind);
    EXPECT_EQ(all.back().sequence - all.front().sequence + 1, all.size());
  }
  EXPECT_GT(share_of(frames.of(StreamKind::kDepth).back(), depth_mm_of(600)), 0.85);
  EXPECT_EQ(frames.of(StreamKind::kColour).back().bytes->size(), 640u * 480 * 3);
  const auto calibration = (*source)->calibration(streams);
  ASSERT_TRUE(calibration);
  EXPECT_EQ(calibration->colour.intrinsics, calibration->depth.intrinsics);
}

/// What the Kinect of that name sees.
void expect_depth(const std::string& uri, int raw_depth) {
  KeptFrames frames;
  const auto source = open_camera(uri, {}, {});
  ASSERT_TRUE(source) << uri << ": " << source.error().text();
  ASSERT_TRUE((*source)->start(std::vector{(*source)->profiles()[0]}, frames.frame_sink(), frames.event_sink()));
  ASSERT_TRUE(frames.wait_for(StreamKind::kDepth, 2)) << uri;
  (*source)->stop();
  EXPECT_GT(share_of(frames.of(StreamKind::kDepth).back(), depth_mm_of(raw_depth)), 0.85) << uri;
}

TEST(EmulatedKinect, OfSeveralIsTheOneThatWasNamed) {
  EmulatedBus bus;
  // Those for Windows need more than the model has; here they are in the way only, before and after the others.
  bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "W1", .product = 0x02bf}));
  bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "A00000000000000A", .raw_depth = 500}));
  bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "B00000000000000B", .raw_depth = 600}));
  bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "W2", .product = 0x02bf}));
  expect_depth("kinect1:1", 500);
  expect_depth("kinect1:2", 600);
  expect_depth("kinect1:A00000000000000A", 500);
  expect_depth("kinect1:B00000000000000B", 600);
}

TEST(EmulatedKinect, WithoutASerialNumberIsKnownByItsPlace) {
  EmulatedBus bus;
  for (const int raw_depth : {500, 600}) {
    bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "0000000000000000", .raw_depth = raw_depth}));
  }
  const auto cameras = list_cameras();
  ASSERT_TRUE(cameras && cameras->size() == 2);
  EXPECT_EQ((*cameras)[1].uri, "kinect1:1");
  EXPECT_EQ((*cameras)[1].serial, "");
  expect_depth("kinect1:0", 500);
  expect_depth("kinect1:1", 600);
}

TEST(EmulatedKinect, PluggedInAgainIsTheSameOneThoughItsPlaceIsAnother) {
  EmulatedBus bus;
  KeptFrames frames;
  const int address = bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "MINE", .raw_depth = 600}));
  bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "ANOTHER", .raw_depth = 500}));
  DeviceOptions options;
  options.reconnect_s = 20;
  const auto source = open_camera("kinect1:0", options, {});
  ASSERT_TRUE(source) << source.error().text();
  ASSERT_TRUE((*source)->start(std::vector{(*source)->profiles()[0]}, frames.frame_sink(), frames.event_sink()));
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, 2));
  bus.unplug(address);
  EXPECT_TRUE(frames.wait_for(DeviceEvent::Kind::kLeft));
  bus.plug_model(std::make_unique<VKinect>(VKinectOptions{.serial = "MINE", .raw_depth = 700}));
  EXPECT_TRUE(frames.wait_for(DeviceEvent::Kind::kReturned));
  const std::size_t so_far = frames.of(StreamKind::kDepth).size();
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, so_far + 2));
  (*source)->stop();
  EXPECT_GT(share_of(frames.of(StreamKind::kDepth).back(), depth_mm_of(700)), 0.85);
}

TEST(EmulatedKinect, NeverGivesAPictureWithAPacketMissing) {
  EmulatedBus bus;
  KeptFrames frames;
  const int address = bus.plug_model(std::make_unique<VKinect>());
  const auto source = open_camera("kinect1:", {}, {});
  ASSERT_TRUE(source) << source.error().text();
  ASSERT_TRUE((*source)->start(std::vector{(*source)->profiles()[0]}, frames.frame_sink(), frames.event_sink()));
  // The Kinect streams before libfreenect listens: how many pictures that costs is not ours to say.
  ASSERT_TRUE(frames.wait_for(StreamKind::kDepth, 1));
  const auto lost_so_far = (*source)->losses().transport;
  bus.with_model(address, [](UsbModel& model) {
    auto& kinect = dynamic_cast<VKinect&>(model);
    kinect.loses_packet[kinect.depth_pictures + 2] = true;
  });
  ASSERT_TRUE(frames.wait_for(StreamKind::kDepth, frames.of(StreamKind::kDepth).size() + 10));
  (*source)->stop();
  EXPECT_EQ((*source)->losses().transport, lost_so_far + 1);
  const auto depth = frames.of(StreamKind::kDepth);
  EXPECT_EQ(depth.back().sequence - depth.front().sequence, depth.size()) << "one is missing among them";
}

/// Depth from a Kinect with something wrong.
class FaultyKinect : public ::testing::Test {
 protected:
  void begin(const std::function<void(VKinect&)>& spoil) {
    address = bus.plug_model(std::make_unique<VKinect>());
    with_kinect(spoil);
    auto opened = open_camera("kinect1:", {}, {});
    ASSERT_TRUE(opened) << opened.error().text();
    source = std::move(*opened);
    const auto streams = source->profiles();
    const auto wanted = std::span(streams).first(has_colour ? 2 : 1);
    ASSERT_TRUE(source->start(wanted, frames.frame_sink(), frames.event_sink()));
  }
  void with_kinect(const std::function<void(VKinect&)>& change) {
    bus.with_model(address, [&](UsbModel& model) { change(dynamic_cast<VKinect&>(model)); });
  }

  EmulatedBus bus;
  KeptFrames frames;
  std::unique_ptr<DeviceSource> source;
  int address = 0;
  bool has_colour = false;
};

TEST_F(FaultyKinect, ThatFallsSilentIsStartedAgain) {
  begin([](VKinect& kinect) {
    kinect.silent_from = 5;
    kinect.silent_until_starts = 2;
  });
  EXPECT_TRUE(frames.wait_for(DeviceEvent::Kind::kRecovered));
  EXPECT_NE(frames.text_of(DeviceEvent::Kind::kSilent).find("no depth comes"), std::string::npos);
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, 10));
  with_kinect([](VKinect& kinect) { EXPECT_GE(kinect.starts, 2); });
}

TEST_F(FaultyKinect, ThatStaysSilentIsGivenUpWithWords) {
  begin([](VKinect& kinect) { kinect.silent_from = 5; });
  ASSERT_TRUE(frames.wait_for(DeviceEvent::Kind::kFailed));
  const std::string text = frames.text_of(DeviceEvent::Kind::kFailed);
  EXPECT_NE(text.find("no depth comes. Check its cable and power supply"), std::string::npos) << text;
  EXPECT_NE(text.find("started 2 times again"), std::string::npos) << text;
}

TEST_F(FaultyKinect, WhoseColourStaysSilentGoesOnWithoutItAndSaysSo) {
  has_colour = true;
  begin([](VKinect& kinect) { kinect.colour_silent_from = 5; });
  ASSERT_TRUE(frames.wait_for(DeviceEvent::Kind::kNoColour));
  const std::string text = frames.text_of(DeviceEvent::Kind::kNoColour);
  EXPECT_NE(text.find("no colour comes"), std::string::npos) << text;
  EXPECT_NE(text.find("goes on without colour"), std::string::npos) << text;
  const std::size_t so_far = frames.of(StreamKind::kDepth).size();
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, so_far + 10));
  EXPECT_EQ(frames.text_of(DeviceEvent::Kind::kFailed), "");
  with_kinect([](VKinect& kinect) { EXPECT_EQ(kinect.starts, 1) << "depth was left alone"; });
}

TEST_F(FaultyKinect, ThatSendsDamagedPicturesOnlyIsGivenUpWithTheirCount) {
  begin([](VKinect& kinect) { kinect.loses_packets_from = 5; });
  ASSERT_TRUE(frames.wait_for(DeviceEvent::Kind::kFailed));
  const std::string text = frames.text_of(DeviceEvent::Kind::kFailed);
  EXPECT_NE(text.find(" damaged pictures did"), std::string::npos) << text;
  EXPECT_GE(source->losses().transport, 5u);
}

TEST_F(FaultyKinect, ThatAnswersNothingAnyMoreIsStopped) {
  begin([](VKinect&) {});
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, 3));
  with_kinect([](VKinect& kinect) { kinect.is_mute = true; });
  const auto before = std::chrono::steady_clock::now();
  source->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
}

TEST_F(FaultyKinect, ThatAnswersNothingIsNotWaitedForForEver) {
  address = bus.plug_model(std::make_unique<VKinect>());
  with_kinect([](VKinect& kinect) { kinect.is_mute = true; });
  const auto opened = open_camera("kinect1:", {}, {});
  if (opened) {  // libfreenect does not look at all of its requests
    EXPECT_TRUE((*opened)->start((*opened)->profiles(), frames.frame_sink(), frames.event_sink()));
    EXPECT_TRUE(frames.wait_for(DeviceEvent::Kind::kFailed));
  }
}

TEST(EmulatedKinect, ThatIsUnpluggedEndsCleanly) {
  EmulatedBus bus;
  KeptFrames frames;
  const int address = bus.plug_model(std::make_unique<VKinect>());
  auto source = open_camera("", {}, {});
  ASSERT_TRUE(source) << source.error().text();
  ASSERT_TRUE((*source)->start((*source)->profiles(), frames.frame_sink(), frames.event_sink()));
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, 3));
  bus.unplug(address);
  EXPECT_TRUE(frames.wait_for(DeviceEvent::Kind::kLeft));
  const auto before = std::chrono::steady_clock::now();
  (*source)->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 10s) << "the wait is bounded";
}

}  // namespace
}  // namespace scanknit::test
