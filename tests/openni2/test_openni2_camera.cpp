// An unmodified libOpenNI2 with our emulated driver in it, and its own player of files.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "acquire/layouts/oni_file.h"
#include "acquire/openni2/openni2_plugin.h"
#include "tests/acquire/kept_frames.h"
#include "tests/app/module_folder.h"
#include "tests/app/program.h"
#include "tests/openni2/emulated_driver.h"
#include "tests/openni2/emulated_pictures.h"
#include "tests/openni2/oni_recorder.h"

namespace scanknit::test {
namespace {

using namespace std::chrono_literals;

void tell_driver(const char* function) {
  void* driver = ::dlopen(SCANKNIT_EMULATED_DRIVER, RTLD_NOW | RTLD_NOLOAD);
  ASSERT_NE(driver, nullptr) << "the library has not loaded the driver";
  reinterpret_cast<void (*)()>(::dlsym(driver, function))();
  ::dlclose(driver);
}

const void* truth_of(const RawFrame& frame, std::size_t n) {
  const EmulatedPicture& picture = emulated_picture(n);
  return frame.profile.kind == StreamKind::kDepth ? static_cast<const void*>(picture.depth_mm.data())
                                                  : picture.rgb.data();
}

/// Each is one of them, bit by bit, with its time.
void expect_the_drivers_pictures(const std::vector<RawFrame>& frames) {
  ASSERT_FALSE(frames.empty());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    bool is_found = false;
    for (std::size_t k = 0; k < kEmulatedPictures && !is_found; ++k) {
      is_found = std::memcmp(frames[i].bytes->data(), truth_of(frames[i], k), frames[i].bytes->size()) == 0;
    }
    EXPECT_TRUE(is_found) << "picture " << i << " is none of the driver's";
    if (i == 0) continue;
    EXPECT_GT(frames[i].sequence, frames[i - 1].sequence);
    const auto gap = static_cast<double>(frames[i].sequence - frames[i - 1].sequence);
    EXPECT_NEAR(static_cast<double>(frames[i].device_ns - frames[i - 1].device_ns), gap * 1e9 / 30, 2000);
  }
}

TEST(OpenNi2Camera, IsListed) {
  const auto cameras = list_openni2();
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].uri, std::string("openni2:") + kEmulatedUri);
  EXPECT_EQ(cameras[0].name, "ScanKnit emulated camera");
}

TEST(OpenNi2Camera, StreamsWhatItsDriverSends) {
  KeptFrames received;
  const auto camera = open_camera("openni2:", {}, {});
  ASSERT_TRUE(camera) << camera.error().text();
  const auto streams = (*camera)->profiles();
  ASSERT_EQ(streams.size(), 2u);
  EXPECT_EQ(streams[0], (StreamProfile{StreamKind::kDepth, PixelFormat::kZ16, 320, 240, 30}));
  EXPECT_EQ(streams[1], (StreamProfile{StreamKind::kColour, PixelFormat::kRgb8, 320, 240, 30}));
  ASSERT_TRUE((*camera)->start(streams, received.frame_sink(), received.event_sink()));
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, 15));
  EXPECT_TRUE(received.wait_for(StreamKind::kColour, 15));
  const auto before = std::chrono::steady_clock::now();
  (*camera)->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
  expect_the_drivers_pictures(received.of(StreamKind::kDepth));
  expect_the_drivers_pictures(received.of(StreamKind::kColour));
  // The library keeps the newest picture only: what a busy computer misses is counted.
  const auto depth = received.of(StreamKind::kDepth), colour = received.of(StreamKind::kColour);
  const auto missed = [](const std::vector<RawFrame>& frames) {
    return frames.back().sequence - frames.front().sequence + 1 - frames.size();
  };
  EXPECT_EQ((*camera)->losses().device, missed(depth) + missed(colour));
  EXPECT_EQ((*camera)->losses().transport, 0u);
}

TEST(OpenNi2Camera, IsCalibratedByItsFieldOfView) {
  const auto camera = open_camera("openni2:", {}, {});
  ASSERT_TRUE(camera) << camera.error().text();
  const auto calibration = (*camera)->calibration((*camera)->profiles());
  ASSERT_TRUE(calibration) << calibration.error().text();
  constexpr double kOfFloatAngles = 1e-3;  // pixels
  EXPECT_NEAR(calibration->depth.intrinsics.fx, kEmulatedCamera.fx, kOfFloatAngles);
  EXPECT_NEAR(calibration->depth.intrinsics.fy, kEmulatedCamera.fy, kOfFloatAngles);
  EXPECT_EQ(calibration->depth.intrinsics.cx, kEmulatedCamera.cx);
  EXPECT_EQ(calibration->depth_unit_m, 0.001);
  EXPECT_EQ(calibration->colour.intrinsics, calibration->depth.intrinsics) << "depth is moved into the colour camera";
}

TEST(OpenNi2Camera, UnpluggedSaysSo) {
  KeptFrames received;
  const auto camera = open_camera("openni2:", {}, {});
  ASSERT_TRUE(camera) << camera.error().text();
  ASSERT_TRUE((*camera)->start((*camera)->profiles(), received.frame_sink(), received.event_sink()));
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, 2));
  tell_driver("scanknit_emulated_unplug");
  EXPECT_TRUE(received.wait_for(DeviceEvent::Kind::kLeft));
  const auto before = std::chrono::steady_clock::now();
  (*camera)->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - before, 1s);
}

TEST(OpenNi2Camera, ThatFallsSilentIsStartedAgain) {
  KeptFrames received;
  const auto camera = open_camera("openni2:", {}, {});
  ASSERT_TRUE(camera) << camera.error().text();
  ASSERT_TRUE((*camera)->start((*camera)->profiles(), received.frame_sink(), received.event_sink()));
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, 2));
  tell_driver("scanknit_emulated_fall_silent");
  EXPECT_TRUE(received.wait_for(DeviceEvent::Kind::kRecovered));
  const std::size_t so_far = received.of(StreamKind::kDepth).size();
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, so_far + 3));
  (*camera)->stop();
  const auto depth = received.of(StreamKind::kDepth);
  for (std::size_t i = 1; i < depth.size(); ++i) {
    EXPECT_GT(depth[i].sequence, depth[i - 1].sequence);
    EXPECT_GT(depth[i].device_ns, depth[i - 1].device_ns) << "though the driver counts its time anew";
  }
}

TEST(OpenNi2Camera, ThatStaysSilentIsGivenUpWithWords) {
  KeptFrames received;
  const auto camera = open_camera("openni2:", {}, {});
  ASSERT_TRUE(camera) << camera.error().text();
  ASSERT_TRUE((*camera)->start((*camera)->profiles(), received.frame_sink(), received.event_sink()));
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, 2));
  tell_driver("scanknit_emulated_stay_silent");
  EXPECT_TRUE(received.wait_for(DeviceEvent::Kind::kFailed));
  const std::string text = received.text_of(DeviceEvent::Kind::kFailed);
  EXPECT_NE(text.find("no good depth for 2 s"), std::string::npos) << text;
  (*camera)->stop();
}

TEST(OpenNi2Camera, WhoseColourStaysSilentGoesOnWithoutItAndSaysSo) {
  KeptFrames received;
  const auto camera = open_camera("openni2:", {}, {});
  ASSERT_TRUE(camera) << camera.error().text();
  ASSERT_TRUE((*camera)->start((*camera)->profiles(), received.frame_sink(), received.event_sink()));
  EXPECT_TRUE(received.wait_for(StreamKind::kColour, 2));
  tell_driver("scanknit_emulated_lose_colour");
  ASSERT_TRUE(received.wait_for(DeviceEvent::Kind::kNoColour));
  const std::string text = received.text_of(DeviceEvent::Kind::kNoColour);
  EXPECT_NE(text.find("no good colour for 2 s"), std::string::npos) << text;
  EXPECT_NE(text.find("goes on without colour"), std::string::npos) << text;
  const std::size_t so_far = received.of(StreamKind::kDepth).size();
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, so_far + 10));
  EXPECT_EQ(received.text_of(DeviceEvent::Kind::kFailed), "");
  (*camera)->stop();
  expect_the_drivers_pictures(received.of(StreamKind::kDepth));
}

TEST(OpenNi2Camera, PluggedInAgainGoesOn) {
  KeptFrames received;
  DeviceOptions options;
  options.reconnect_s = 5;
  const auto camera = open_camera("openni2:", options, {});
  ASSERT_TRUE(camera) << camera.error().text();
  ASSERT_TRUE((*camera)->start((*camera)->profiles(), received.frame_sink(), received.event_sink()));
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, 2));
  tell_driver("scanknit_emulated_unplug");
  EXPECT_TRUE(received.wait_for(DeviceEvent::Kind::kReturned));
  const std::size_t so_far = received.of(StreamKind::kDepth).size();
  EXPECT_TRUE(received.wait_for(StreamKind::kDepth, so_far + 3));
  (*camera)->stop();
}

TEST(OpenNi2Camera, CapturedBecomesAMesh) {
  const TempFolder out;
  const Outcome capture = scanknit_command({"capture", "--device", "openni2:", "--frames", "14", "-o",
                                            (out / "desk.ply").string(), "--set", "fusion.voxel_size=8mm"});
  EXPECT_EQ(capture.exit_code, 0) << capture.err;
  EXPECT_GT(std::filesystem::file_size(out / "desk.ply"), 10'000u);
  EXPECT_TRUE(std::filesystem::exists(out / "desk.mcap"));
}

// OpenNI's player is an independent reader of the file: it shows what we read.
TEST(OpenNi2File, PlaysAsWeReadIt) {
  const TempFolder folder;
  ASSERT_TRUE(record_oni(folder / "desk.oni"));
  const OniFile file = OniFile::open(open_random_access(folder / "desk.oni").value(), {}).value();
  KeptFrames received;
  const auto player = open_camera("openni2:" + (folder / "desk.oni").string(), {}, {});
  ASSERT_TRUE(player) << player.error().text();
  ASSERT_TRUE((*player)->start((*player)->profiles(), received.frame_sink(), received.event_sink()));
  EXPECT_TRUE(received.wait_for(DeviceEvent::Kind::kFailed)) << "it ends with the file";
  (*player)->stop();
  const auto depth = received.of(StreamKind::kDepth);
  ASSERT_GE(depth.size(), file.depth().pictures.size() / 2);
  std::size_t next = 0;
  for (const RawFrame& frame : depth) {
    bool is_found = false;
    while (next < file.depth().pictures.size() && !is_found) {
      is_found = *file.read(StreamKind::kDepth, next++).value().bytes == *frame.bytes;
    }
    EXPECT_TRUE(is_found) << "a picture that is not in the file, or not in its order";
  }
}

TEST(OpenNi2File, IsNotGivenToThePlayerWhenItIsTorn) {
  const TempFolder folder;
  ASSERT_TRUE(record_oni(folder / "desk.oni"));
  std::filesystem::resize_file(folder / "desk.oni", std::filesystem::file_size(folder / "desk.oni") / 2);
  const auto player = open_camera("openni2:" + (folder / "desk.oni").string(), {}, {});
  ASSERT_FALSE(player);
  EXPECT_NE(player.error().message.find("torn"), std::string::npos) << player.error().text();
}

TEST(OpenNi2Plugin, ThatIsMissingSaysWhatToDo) {
  const TempFolder folder;
  const ModuleFolder modules;
  if (!modules.is_used()) GTEST_SKIP() << "SKIPPED: the program of a static build finds its modules beside itself";
  std::ofstream(modules / "libscanknit_openni2.so") << "no library";
  const Outcome outcome = modules.run({"record", "--device", "openni2:", "-o", (folder / "a.mcap").string()});
  EXPECT_EQ(outcome.exit_code, 5);
  EXPECT_NE(outcome.err.find("libopenni2-0"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("package scanknit-openni2"), std::string::npos) << outcome.err;
  const Outcome listed = modules.run({"devices", "-v"});
  EXPECT_NE(listed.err.find("OpenNI2 cameras are not listed: "), std::string::npos) << listed.err;
}

}  // namespace
}  // namespace scanknit::test
