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

TEST(EmulatedKinect, IsListed) {
  EmulatedBus bus;
  bus.plug_model(std::make_unique<VKinect>());
  const auto cameras = list_cameras();
  ASSERT_TRUE(cameras);
  ASSERT_EQ(cameras->size(), 1u);
  EXPECT_EQ(cameras->front().uri, "kinect1:0");
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
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
  EXPECT_EQ((*source)->losses().total(), 0u);
  // A disparity of 600 with the model's geometry: fixed_x = (600 - 4 * 200) / 4 - 0.375 pixels of 0.1042 cm at 120 cm,
  // emitter at 7.5 cm.
  const double x_cm = ((600 - 4 * 200.0) / 4 - 0.375) * 0.1042;
  const double depth_mm = 10 * (x_cm * 120 / (7.5 - x_cm) + 120);
  const RawFrame last = frames.of(StreamKind::kDepth).back();
  EXPECT_GT(share_of(last, static_cast<std::uint16_t>(depth_mm)), 0.85) << depth_mm;
  EXPECT_EQ(frames.of(StreamKind::kColour).back().bytes->size(), 640u * 480 * 3);
  const auto calibration = (*source)->calibration(streams);
  ASSERT_TRUE(calibration);
  EXPECT_EQ(calibration->colour.intrinsics, calibration->depth.intrinsics);
}

TEST(EmulatedKinect, NeverGivesAPictureWithAPacketMissing) {
  EmulatedBus bus;
  KeptFrames frames;
  const int address = bus.plug_model(std::make_unique<VKinect>());
  bus.with_model(address, [](UsbModel& model) { dynamic_cast<VKinect&>(model).loses_packet[5] = true; });
  const auto source = open_camera("kinect1:", {}, {});
  ASSERT_TRUE(source) << source.error().text();
  ASSERT_TRUE((*source)->start(std::vector{(*source)->profiles()[0]}, frames.frame_sink(), frames.event_sink()));
  EXPECT_TRUE(frames.wait_for(StreamKind::kDepth, 10));
  (*source)->stop();
  EXPECT_EQ((*source)->losses().transport, 1u);
  // The Kinect streams before libfreenect listens: how many pictures that costs is not ours to say.
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
    ASSERT_TRUE(source->start(std::vector{source->profiles()[0]}, frames.frame_sink(), frames.event_sink()));
  }
  void with_kinect(const std::function<void(VKinect&)>& change) {
    bus.with_model(address, [&](UsbModel& model) { change(dynamic_cast<VKinect&>(model)); });
  }

  EmulatedBus bus;
  KeptFrames frames;
  std::unique_ptr<DeviceSource> source;
  int address = 0;
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

TEST_F(FaultyKinect, ThatSendsDamagedPicturesOnlyIsGivenUpWithTheirCount) {
  begin([](VKinect& kinect) { kinect.loses_packets_from = 5; });
  ASSERT_TRUE(frames.wait_for(DeviceEvent::Kind::kFailed));
  const std::string text = frames.text_of(DeviceEvent::Kind::kFailed);
  EXPECT_NE(text.find(" damaged pictures did"), std::string::npos) << text;
  EXPECT_GE(source->losses().transport, 5u);
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
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
}

}  // namespace
}  // namespace scanknit::test
