// An unmodified libusb, our driver, an emulated camera: what works when nothing goes wrong.
#include <array>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "tests/usb/emulated/live_camera.h"

namespace scanknit::test {
namespace {

class EmulatedCamera : public OneCamera {};

TEST_F(EmulatedCamera, IsListedWithoutBeingOpened) {
  address = bus.plug({});
  const auto cameras = list_cameras();
  ASSERT_TRUE(cameras) << cameras.error().text();
  ASSERT_EQ(cameras->size(), 1u);
  EXPECT_EQ(cameras->front().uri, "usb:8086:0b07/0123456789ab");
  EXPECT_EQ(cameras->front().name, "Intel RealSense D435");
  EXPECT_EQ(cameras->front().speed_mbit, 5000);
  EXPECT_EQ(cameras->front().address, address);
}

TEST_F(EmulatedCamera, OffersItsProfiles) {
  ASSERT_NO_FATAL_FAILURE(open());
  const auto profiles = source->profiles();
  EXPECT_EQ(profiles.size(), 12u);  // four rates of Z16, YUYV and MJPEG
  const auto chosen = choose_streams(profiles, 640, 480, 30);
  ASSERT_EQ(chosen.size(), 2u);
  EXPECT_EQ(chosen[0], (StreamProfile{StreamKind::kDepth, PixelFormat::kZ16, 640, 480, 30}));
  EXPECT_EQ(chosen[1], (StreamProfile{StreamKind::kColour, PixelFormat::kYuyv, 640, 480, 30}));
}

struct Stream {
  const char* name;
  VcamOptions options;
  double fps;
  std::optional<PixelFormat> colour;
};

void PrintTo(const Stream& stream, std::ostream* out) {
  *out << stream.name;
}

class EmulatedStream : public ::testing::TestWithParam<Stream> {};

TEST_P(EmulatedStream, ArrivesWithoutALoss) {
  const Stream& setup = GetParam();
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug(setup.options);
  const auto source = open_first();
  ASSERT_TRUE(source) << source.error().text();
  const auto streams = streams_of(**source, setup.fps, setup.colour);
  ASSERT_EQ(streams.size(), setup.colour ? 2u : 1u);
  const auto started = (*source)->start(streams, log.frame_sink(), log.event_sink());
  ASSERT_TRUE(started) << started.error().text();
  const std::size_t frames = setup.fps > 60 ? 90 : setup.fps < 30 ? 15 : 30;  // a second
  EXPECT_TRUE(log.wait_for_depth(frames));
  EXPECT_TRUE(!setup.colour || log.wait_for_colour(frames));
  (*source)->stop();
  const auto numbers = log.depth();
  std::vector<int> all(numbers.size());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(numbers, all);
  EXPECT_EQ((*source)->losses().total(), 0u);
  EXPECT_EQ(bus.waiting_transfers(address), 0) << "all transfers were taken back";
  EXPECT_LT(bus.idle_asks(address).value_or(0), 500) << "no busy waiting";
}

INSTANTIATE_TEST_SUITE_P(
    All, EmulatedStream,
    ::testing::Values(
        Stream{"DepthAt30", {}, 30, {}}, Stream{"DepthAndYuyvAt30", {}, 30, PixelFormat::kYuyv},
        Stream{"DepthAndYuyvAt60", {}, 60, PixelFormat::kYuyv},
        Stream{"HdDepthAt30", {.width = 1280, .height = 720}, 30, {}},
        Stream{"DepthAndYuyvAt90", {}, 90, PixelFormat::kYuyv},
        Stream{"DepthAndMjpegAt90", {}, 90, PixelFormat::kMjpeg},
        Stream{"SmallPayloads", {.payload_bytes = 16384}, 30, {}},
        Stream{"MiddlingPayloads", {.payload_bytes = 65536}, 60, PixelFormat::kYuyv},
        Stream{"Isochronous", {.is_isochronous = true, .speed_mbit = 480}, 30, {}},
        Stream{"IsochronousColour", {.has_isochronous_colour = true, .speed_mbit = 480}, 15, PixelFormat::kYuyv},
        Stream{"IsochronousMjpeg", {.has_isochronous_colour = true, .speed_mbit = 480}, 15, PixelFormat::kMjpeg},
        Stream{"BothIsochronous",
               {.is_isochronous = true, .has_isochronous_colour = true, .speed_mbit = 480},
               15,
               PixelFormat::kYuyv},
        Stream{"Uvc10", {.uvc_version = 0x0100}, EmulatedBus::kBriskFps, PixelFormat::kYuyv},
        Stream{"Uvc11", {.uvc_version = 0x0110}, EmulatedBus::kBriskFps, PixelFormat::kYuyv},
        Stream{"D16Only", {.depth_code = std::string("\x50\0\0\0", 4)}, EmulatedBus::kBriskFps, {}},
        Stream{"Y16OfAnUnknownCamera",
               {.vendor = 0x1234, .product = 0x5678, .has_metadata = false, .depth_code = "Y16 "},
               EmulatedBus::kBriskFps,
               {}},
        Stream{"EndpointAttached", {.hangs_on_endpoint = true}, EmulatedBus::kBriskFps, {}}),
    [](const auto& test) { return test.param.name; });

/// Of this process' thread of that name.
double cpu_seconds_of(const std::string& thread) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string name;
    std::getline(std::ifstream(task.path() / "comm"), name);
    double nanoseconds = 0;
    std::ifstream(task.path() / "schedstat") >> nanoseconds;
    if (name == thread) return nanoseconds * 1e-9;
  }
  return 0;
}

TEST_F(EmulatedCamera, At90FramesASecondLeavesTheProcessorAlone) {
  ASSERT_NO_FATAL_FAILURE(open());
  const auto streams = streams_of(*source, 90, PixelFormat::kYuyv);
  std::mutex mutex;
  std::vector<double> latencies_ms;
  const auto sink = [&](const RawFrame& frame) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch() / 1ns;
    const std::lock_guard lock(mutex);
    latencies_ms.push_back(1e-6 * static_cast<double>(now - frame.host_ns));
  };
  ASSERT_TRUE(source->start(streams, sink, [](const DeviceEvent&) {}));
  std::this_thread::sleep_for(2s);
  const double used_s = cpu_seconds_of("usb");
  source->stop();
  std::sort(latencies_ms.begin(), latencies_ms.end());
  ASSERT_GT(latencies_ms.size(), 100u);
  const double median_ms = latencies_ms[latencies_ms.size() / 2];
  const double frames = static_cast<double>(latencies_ms.size());
  RecordProperty("cpu_us_a_frame", static_cast<int>(1e6 * used_s / frames));
  RecordProperty("latency_us", static_cast<int>(1000 * median_ms));
  EXPECT_LT(median_ms, 2.0) << "from the last byte to the frame";
  // 110 MB/s; the promise is 5 % of a core. A machine that is busy with other things takes longer.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(used_s / 2, 0.2);
#endif
}

TEST_F(EmulatedCamera, TellsItsCalibration) {
  ASSERT_NO_FATAL_FAILURE(open());
  const auto streams = streams_of(*source, 30, PixelFormat::kYuyv);
  const auto calibration = source->calibration(streams);
  ASSERT_TRUE(calibration) << calibration.error().text();
  EXPECT_EQ(calibration->depth.intrinsics, (CameraIntrinsics{640, 480, 380, 381, 319, 241}));
  EXPECT_NEAR(calibration->colour.intrinsics.fx, 1400 * 480.0 / 1080, 1e-3);
  EXPECT_EQ(calibration->depth_unit_m, 0.001);
  EXPECT_EQ(calibration->source, "the camera's own");
  EXPECT_EQ(calibration->serial, "0123456789ab");
}

struct CalibrationFault {
  const char* name;
  bool ControlFaults::*fault;
  const char* words;
};

void PrintTo(const CalibrationFault& fault, std::ostream* out) {
  *out << fault.name;
}

class UnreadableCalibration : public ::testing::TestWithParam<CalibrationFault> {};

TEST_P(UnreadableCalibration, IsToldOfAndTheCameraStreamsWithTheUsers) {
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug({});
  bus.with_camera(address, [](Vcam& camera) { camera.control_faults.*GetParam().fault = true; });
  {
    const auto source = open_first();
    ASSERT_TRUE(source);
    const auto none = (*source)->calibration(streams_of(**source, 30));
    ASSERT_TRUE(none);
    EXPECT_EQ(none->depth.intrinsics.width, 0);
    EXPECT_NE(none->depth_unknown.find(GetParam().words), std::string::npos) << none->depth_unknown;
    EXPECT_EQ(none->colour_unknown, none->depth_unknown);
  }
  DeviceOptions options;
  options.intrinsics = CameraModel{{0, 0, 500, 500, 320, 240}, {}};
  const auto source = open_first(options);
  ASSERT_TRUE(source);
  const auto streams = streams_of(**source, EmulatedBus::kBriskFps);
  const auto given = (*source)->calibration(streams);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->depth.intrinsics, (CameraIntrinsics{640, 480, 500, 500, 320, 240}));
  EXPECT_NE(given->source.find("acquire.intrinsics ("), std::string::npos) << given->source;
  EXPECT_EQ(given->depth_unknown, "");
  EXPECT_NE(given->colour_unknown, "") << "the user says nothing of the colour camera";
  ASSERT_TRUE((*source)->start(streams, log.frame_sink(), log.event_sink()));
  EXPECT_TRUE(log.wait_for_depth(5));
}

INSTANTIATE_TEST_SUITE_P(
    All, UnreadableCalibration,
    ::testing::Values(CalibrationFault{"Stall", &ControlFaults::has_no_calibration, "the camera refused it"},
                      CalibrationFault{"NoAnswer", &ControlFaults::has_mute_calibration, "no answer in time"},
                      CalibrationFault{"BadChecksum", &ControlFaults::has_broken_calibration, "wrong checksum"}),
    [](const auto& test) { return test.param.name; });

TEST_F(EmulatedCamera, WhoseColourTableIsBrokenTellsItsDepthCalibrationAndWhy) {
  ASSERT_NO_FATAL_FAILURE(open({}, [](Vcam& camera) { camera.control_faults.has_broken_colour = true; }));
  const auto calibration = source->calibration(streams_of(*source, 30, PixelFormat::kYuyv));
  ASSERT_TRUE(calibration);
  EXPECT_EQ(calibration->depth.intrinsics, (CameraIntrinsics{640, 480, 380, 381, 319, 241}));
  EXPECT_EQ(calibration->depth_unknown, "");
  EXPECT_NE(calibration->colour_unknown.find("table 32 has a wrong checksum"), std::string::npos)
      << calibration->colour_unknown;
}

TEST_F(EmulatedCamera, TellsItsDepthUnit) {
  ASSERT_NO_FATAL_FAILURE(open({.depth_unit_um = 250}));
  const auto calibration = source->calibration(streams_of(*source, 30));
  ASSERT_TRUE(calibration);
  EXPECT_DOUBLE_EQ(calibration->depth_unit_m, 0.00025);
  EXPECT_TRUE(calibration->warnings.empty()) << calibration->warnings.front();
}

TEST_F(EmulatedCamera, ThatDoesNotTellItsDepthUnitHasTheUsualOneOfItsKindAndSaysSo) {
  ASSERT_NO_FATAL_FAILURE(
      open({.product = 0x0b5b}, [](Vcam& camera) { camera.control_faults.has_no_advanced_mode = true; }));
  const auto calibration = source->calibration(streams_of(*source, 30));
  ASSERT_TRUE(calibration);
  EXPECT_EQ(calibration->depth_unit_m, 0.0001);
  ASSERT_EQ(calibration->warnings.size(), 1u);
  EXPECT_NE(calibration->warnings[0].find("0.1 mm is taken"), std::string::npos) << calibration->warnings[0];
}

TEST_F(EmulatedCamera, WhoseDepthUnitTheUserStatesIsNotAsked) {
  DeviceOptions options;
  options.depth_scale = 5000;
  const auto cannot_tell = [](Vcam& camera) { camera.control_faults.has_no_advanced_mode = true; };
  ASSERT_NO_FATAL_FAILURE(open({.depth_unit_um = 250}, cannot_tell, options));
  const auto calibration = source->calibration(streams_of(*source, 30));
  ASSERT_TRUE(calibration);
  EXPECT_DOUBLE_EQ(calibration->depth_unit_m, 1.0 / 5000);
  EXPECT_TRUE(calibration->warnings.empty());
}

TEST_F(EmulatedCamera, TakesControls) {
  ASSERT_NO_FATAL_FAILURE(open());
  EXPECT_TRUE(source->set_control(DeviceControl::kEmitter, 1));
  EXPECT_TRUE(source->set_control(DeviceControl::kLaserPower, 300));
  EXPECT_TRUE(source->set_control(DeviceControl::kColourAutomatics, 0));
  bus.with_camera(address, [](Vcam& camera) {
    EXPECT_EQ((camera.written[{0x0300, 0x0200}]), (std::vector{std::byte{1}, std::byte{0}}));
    EXPECT_EQ((camera.written[{0x0300, 0x0400}]), (std::vector{std::byte{0x2C}, std::byte{0x01}}));
    EXPECT_EQ((camera.written[{0x0102, 0x0200}]), std::vector{std::byte{1}}) << "exposure is manual";
    EXPECT_EQ((camera.written[{0x0202, 0x0B00}]), std::vector{std::byte{0}}) << "white balance is held";
  });
}

/// A RealSense, and a camera of which nothing is known but its descriptors.
class InfraredCamera : public ::testing::TestWithParam<int> {};

TEST_P(InfraredCamera, IsNotTakenForColourOrDepth) {
  EmulatedBus bus;
  FrameLog log;
  const int address = bus.plug({.vendor = static_cast<std::uint16_t>(GetParam()), .has_infrared = true});
  const auto source = open_first();
  ASSERT_TRUE(source);
  EXPECT_EQ(std::ranges::count((*source)->profiles(), PixelFormat::kUyvy, &StreamProfile::format), 0);
  const bool offers_pairs = std::ranges::count((*source)->profiles(), PixelFormat::kY8i, &StreamProfile::format) > 0;
  EXPECT_EQ(offers_pairs, GetParam() == 0x8086) << "only where the baseline can be read";
  EXPECT_EQ(choose_streams((*source)->profiles(), 640, 480, 30).at(0).format, PixelFormat::kZ16);
  const auto streams = streams_of(**source, EmulatedBus::kBriskFps, PixelFormat::kYuyv);
  ASSERT_EQ(streams.size(), 2u);
  ASSERT_TRUE((*source)->start(streams, log.frame_sink(), log.event_sink()));
  EXPECT_TRUE(log.wait_for_depth(5)) << "FrameLog looks at each pixel";
  bus.with_camera(address, [](Vcam& camera) { EXPECT_EQ(camera.depth_format, 1) << "Z16, not Y16"; });
}

INSTANTIATE_TEST_SUITE_P(Vendor, InfraredCamera, ::testing::Values(0x8086, 0x1234),
                         [](const auto& test) { return test.param == 0x8086 ? "Realsense" : "Unknown"; });

TEST_F(EmulatedCamera, FreesExposureThatAKilledScanHasLeftHeld) {
  ASSERT_NO_FATAL_FAILURE(open());
  ASSERT_TRUE(source->set_control(DeviceControl::kColourAutomatics, 0));
  ASSERT_TRUE(start(EmulatedBus::kBriskFps));
  bus.with_camera(address, [](Vcam& camera) {
    EXPECT_EQ((camera.written[{0x0102, 0x0200}]), std::vector{std::byte{8}}) << "exposure follows the light";
    EXPECT_EQ((camera.written[{0x0202, 0x0B00}]), std::vector{std::byte{1}}) << "white balance";
  });
}

TEST_F(EmulatedCamera, HoldsExposureAndWhiteBalanceWhileItStreams) {
  ASSERT_NO_FATAL_FAILURE(open());
  ASSERT_TRUE(start(EmulatedBus::kBriskFps));
  bool is_held = false;
  for (int i = 0; i < 200 && !is_held; ++i) {  // after a second
    std::this_thread::sleep_for(50ms);
    bus.with_camera(address, [&](Vcam& camera) {
      is_held = camera.written[{0x0102, 0x0200}] == std::vector{std::byte{1}};
    });
  }
  EXPECT_TRUE(is_held);
  source->stop();
  bus.with_camera(address, [](Vcam& camera) {
    EXPECT_EQ((camera.written[{0x0102, 0x0200}]), std::vector{std::byte{8}});
  });
}

TEST_F(EmulatedCamera, StopsWithinASecondAndStartsAgain) {
  std::array<FrameLog, 3> logs;
  ASSERT_NO_FATAL_FAILURE(open());
  const auto streams = streams_of(*source, EmulatedBus::kBriskFps, PixelFormat::kYuyv);
  for (FrameLog& each : logs) {
    ASSERT_TRUE(source->start(streams, each.frame_sink(), each.event_sink()));
    EXPECT_FALSE(source->start(streams, each.frame_sink(), each.event_sink())) << "it streams already";
    EXPECT_TRUE(each.wait_for_depth(5));
    const auto before = std::chrono::steady_clock::now();
    source->stop();
    EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
    const std::size_t frames = each.depth().size();
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(each.depth().size(), frames) << "nothing comes after stop";
  }
}

TEST_F(EmulatedCamera, OfTwoIsFoundByItsSerial) {
  FrameLog log_a, log_b;
  bus.plug({.serial = "first"});
  const int second = bus.plug({.serial = "second"});
  const auto a = open_camera("usb:8086:0b07/second", {}, {});
  const auto b = open_camera("usb:8086:0b07/first", {}, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ((*a)->info().address, second);
  ASSERT_TRUE((*a)->start(streams_of(**a, 60), log_a.frame_sink(), log_a.event_sink()));
  ASSERT_TRUE((*b)->start(streams_of(**b, 60), log_b.frame_sink(), log_b.event_sink()));
  EXPECT_TRUE(log_b.wait_for_depth(10));
  bus.unplug(second);
  EXPECT_TRUE(log_a.wait_for(DeviceEvent::Kind::kLeft));
  const std::size_t so_far = log_b.depth().size();
  EXPECT_TRUE(log_b.wait_for_depth(so_far + 20)) << "one failing does not disturb the other";
  EXPECT_EQ((*b)->losses().total(), 0u);
}

TEST_F(EmulatedCamera, OnASlowLinkIsWarnedOf) {
  ASSERT_NO_FATAL_FAILURE(open({.speed_mbit = 480}));
  ASSERT_TRUE(start(90, PixelFormat::kYuyv));
  EXPECT_TRUE(log.wait_for(DeviceEvent::Kind::kSlowLink));
  EXPECT_NE(log.text_of(DeviceEvent::Kind::kSlowLink).find("110.6 MB/s"), std::string::npos)
      << log.text_of(DeviceEvent::Kind::kSlowLink);
}

TEST_F(EmulatedCamera, IsWaitedFor) {
  const std::jthread hand([&] {
    std::this_thread::sleep_for(200ms);
    bus.plug({});
  });
  DeviceOptions options;
  options.wait_s = 5;
  const auto before = std::chrono::steady_clock::now();
  const auto waited = open_first(options);
  ASSERT_TRUE(waited) << waited.error().text();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 3s);
}

TEST_F(EmulatedCamera, ThatIsNotThereIsAnError) {
  const auto none = open_first();
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kDevice);
  EXPECT_NE(none.error().message.find("no depth camera"), std::string::npos);
  const auto nonsense = open_camera("usb:xyz", {}, {});
  ASSERT_FALSE(nonsense);
  EXPECT_EQ(nonsense.error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace scanknit::test
