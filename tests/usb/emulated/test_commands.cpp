// The built program, looking at emulated cameras.
#include <gtest/gtest.h>

#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "acquire/frame_source.h"
#include "export/mesh/read_mesh.h"
#include "tests/app/program.h"
#include "tests/support/text.h"
#include "tests/usb/emulated/emulated_bus.h"
#include "tests/usb/usb_bytes.h"

namespace scanknit::test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr int kSlowness = SCANKNIT_SLOWNESS;  // of a program with sanitizers; 1 without

/// A rough wall one metre away, as depth in millimetres: so rough that its recording is not too small to wait for.
VcamOptions rough_wall() {
  static const std::vector<std::byte> picture = [] {
    std::vector<std::byte> bytes;
    for (std::uint32_t i = 0; i < 640 * 480; ++i) {
      const std::uint32_t depth_mm = 1000 + (i * 2654435761u >> 30);
      bytes.insert(bytes.end(), {static_cast<std::byte>(depth_mm & 0xFF), static_cast<std::byte>(depth_mm >> 8)});
    }
    return bytes;
  }();
  VcamOptions options;
  options.has_colour = false;
  options.depth_picture = [](std::uint64_t) { return picture; };
  return options;
}

TEST(DevicesCommand, ListsWhatIsPluggedIn) {
  EmulatedBus bus;
  const Outcome none = scanknit_command({"devices"});
  EXPECT_EQ(none.exit_code, 0);
  EXPECT_EQ(none.out, "");
  EXPECT_TRUE(contains(none.err, "no depth camera")) << none.err;
  bus.plug({});
  const Outcome one = scanknit_command({"devices"});
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_EQ(one.out,
            "usb:8086:0b07/0123456789ab  Intel RealSense D435, bus 1 address 2, 5000 Mbit/s, tested on an emulated "
            "device\n");
}

TEST(DevicesCommand, PrintsNoCommandsToTheTerminal) {
  EmulatedBus bus;
  bus.plug({.serial = "a\x1b[2Jb\x7f"});
  EXPECT_TRUE(contains(scanknit_command({"devices"}).out, "usb:8086:0b07/a?[2Jb?  "));
}

TEST(DevicesCommand, GivesJson) {
  EmulatedBus bus;
  bus.plug({.serial = ""});
  const json devices = json::parse(scanknit_command({"devices", "--json"}).out).at("devices");
  ASSERT_EQ(devices.size(), 1u);
  EXPECT_EQ(devices[0].at("uri"), "usb:8086:0b07");
  EXPECT_TRUE(devices[0].at("serial").is_null());
  EXPECT_EQ(devices[0].at("speed_mbit"), 5000);
}

TEST(DoctorCommand, FindsNothingWrongWithAGoodCamera) {
  EmulatedBus bus;
  bus.plug({});
  const Outcome outcome = scanknit_command({"doctor"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "ok       permission")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "ok       link: 5000 Mbit/s")) << outcome.out;
}

TEST(DoctorCommand, WithoutACameraExitsWith5AndARemedy) {
  EmulatedBus bus;
  const Outcome outcome = scanknit_command({"doctor"});
  EXPECT_EQ(outcome.exit_code, 5);
  EXPECT_TRUE(contains(outcome.out, "problem  no depth camera among 0 USB devices")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "-> plug the camera in")) << outcome.out;
}

/// A device of which only the numbers matter: none of our drivers streams from it.
class PlainDevice final : public UsbModel {
 public:
  PlainDevice(std::uint16_t vendor, std::uint16_t product) : vendor_(vendor), product_(product) {}
  [[nodiscard]] UsbIdentity identity() const override { return {vendor_, product_, "", 480}; }
  [[nodiscard]] std::vector<ModelEndpoint> endpoints() const override { return {}; }
  [[nodiscard]] std::vector<std::byte> descriptors() const override {
    Bytes bytes{18, 1, 0, 2, 0, 0, 0, 64};
    bytes.u16(vendor_).u16(product_).u16(1).add({0, 0, 0, 1}).add({9, 2, 18, 0, 1, 1, 0, 0x80, 250});
    return bytes.add({9, 4, 0, 0, 0, 0xFF, 0, 0, 0}).vector();
  }
  [[nodiscard]] std::optional<std::vector<std::byte>> control(std::uint8_t, std::uint8_t, std::uint16_t, std::uint16_t,
                                                              std::uint16_t, std::span<const std::byte>,
                                                              std::int64_t) override {
    return std::nullopt;
  }
  void set_alternate(std::uint8_t, std::uint8_t, std::int64_t) override {}
  void clear_halt(std::uint8_t) override {}
  [[nodiscard]] std::optional<Delivery> fill_transfer(std::uint8_t, std::span<std::byte>, std::int64_t) override {
    return std::nullopt;
  }
  void nobody_asked(std::uint8_t, std::int64_t) override {}
  [[nodiscard]] Delivery fill_packet(std::uint8_t, std::span<std::byte>, std::int64_t) override { return {}; }

 private:
  std::uint16_t vendor_, product_;
};

TEST(DoctorCommand, KnowsACameraForOpenNi2) {
  EmulatedBus bus;
  bus.plug_model(std::make_unique<PlainDevice>(0x1d27, 0x0601));
  const Outcome outcome = scanknit_command({"doctor"});
  EXPECT_TRUE(contains(outcome.out, "PrimeSense camera")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "ok       permission: ")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "OpenNI2: ")) << outcome.out;
  EXPECT_FALSE(contains(outcome.out, "no depth camera")) << outcome.out;
}

TEST(DoctorCommand, SaysThatAUsb2LinkIsNarrow) {
  EmulatedBus bus;
  bus.plug({.speed_mbit = 480});
  const json found = json::parse(scanknit_command({"doctor", "--json"}).out);
  bool is_said = false;
  for (const json& finding : found.at("devices").at(0).at("findings")) {
    if (!contains(finding.at("text"), "link: 480 Mbit/s")) continue;
    is_said = true;
    EXPECT_EQ(finding.at("grade"), "note");
    EXPECT_TRUE(contains(finding.at("text"), "36.9 MB/s"));
    EXPECT_TRUE(contains(finding.at("remedy"), "USB 3"));
  }
  EXPECT_TRUE(is_said);
}

/// Of a file that may be growing.
bool has_depth(const std::filesystem::path& file) {
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  const auto recording = open_recording(file, config);
  return recording && std::holds_alternative<Frame>((*recording)->next({}));
}

/// scanknit in the background, streaming from the emulated camera; waits until `file` has some pictures, of which one
/// at least is of depth. Writing more than `max_file_bytes` fails, as on a full disk.
class Scan {
 public:
  Scan(EmulatedBus& bus, int address, const std::vector<std::string>& arguments, const std::filesystem::path& file,
       std::optional<std::uintmax_t> max_file_bytes = {})
      : program_(arguments, max_file_bytes) {
    bus.serve(address, program_.process());
    const auto deadline = std::chrono::steady_clock::now() + kSlowness * 20s;
    std::error_code none_yet;
    const auto has_pictures = [&] {
      const auto size = std::filesystem::file_size(file, none_yet);
      return !none_yet && size > 400'000 && has_depth(file);
    };
    while (!has_pictures() && program_.is_running() && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(20ms);
    }
    EXPECT_TRUE(has_pictures()) << program_.err_so_far();
  }

  /// False: it did not say so within thirty seconds, or has ended.
  [[nodiscard]] bool wait_to_say(const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + kSlowness * 30s;
    while (program_.err_so_far().find(text) == std::string::npos) {
      if (!program_.is_running() || std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(20ms);
    }
    return program_.is_running();
  }
  [[nodiscard]] Outcome interrupt_once() {
    program_.send(SIGINT);
    return program_.wait();
  }
  /// Again and again, until it ends: signals that come at once are one.
  [[nodiscard]] Outcome interrupt_until_it_ends() {
    while (program_.is_running()) {
      program_.send(SIGINT);
      std::this_thread::sleep_for(2ms);
    }
    return program_.wait();
  }

 private:
  Program program_;
};

std::size_t frames_in(const std::filesystem::path& file, bool& is_torn) {
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  const auto recording = open_recording(file, config);
  EXPECT_TRUE(recording) << recording.error().text();
  if (!recording) return 0;
  is_torn = !(*recording)->info().warnings.empty();
  std::size_t frames = 0;
  while (true) {
    const FrameEvent event = (*recording)->next({});
    if (std::holds_alternative<EndOfStream>(event)) return frames;
    EXPECT_TRUE(std::holds_alternative<Frame>(event)) << "a picture that is not whole";
    ++frames;
  }
}

std::vector<std::string> capture_to(const std::filesystem::path& mesh) {
  return {"capture", "-o", mesh.string(), "--poses", "still", "--fps", "30", "--set", "fusion.voxel_size=2cm"};
}

TEST(Interrupted, CaptureEndsWithTheMesh) {
  EmulatedBus bus;
  const int address = bus.plug(rough_wall());
  TempFolder out;
  Scan scan(bus, address, capture_to(out / "wall.ply"), out / "wall.mcap");
  const Outcome outcome = scan.interrupt_once();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(read_mesh(out / "wall.ply"));
  bool is_torn = true;
  EXPECT_GT(frames_in(out / "wall.mcap", is_torn), 0u);
  EXPECT_FALSE(is_torn);
}

TEST(FullDisk, IsToldOfAtOnceAndTheScanGoesOn) {
  EmulatedBus bus;
  const int address = bus.plug(rough_wall());
  TempFolder out;
  Scan scan(bus, address, capture_to(out / "wall.ply"), out / "wall.mcap", 2'000'000);
  EXPECT_TRUE(scan.wait_to_say("pictures are kept")) << "while it scans";
  const Outcome outcome = scan.interrupt_once();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto told = outcome.err.find("recording has stopped");
  EXPECT_TRUE(contains(outcome.err, "pictures are kept; the scan goes on")) << outcome.err;
  EXPECT_EQ(outcome.err.find("recording has stopped", told + 1), std::string::npos) << "told once: " << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "writer ")) << "pictures that were not kept are counted: " << outcome.err;
  EXPECT_TRUE(read_mesh(out / "wall.ply"));
  bool is_torn = true;
  EXPECT_GT(frames_in(out / "wall.mcap", is_torn), 0u);
}

TEST(Interrupted, CaptureStopsAtOnceTheSecondTime) {
  EmulatedBus bus;
  const int address = bus.plug(rough_wall());
  TempFolder out;
  Scan scan(bus, address, capture_to(out / "wall.ply"), out / "wall.mcap");
  EXPECT_EQ(scan.interrupt_until_it_ends().exit_code, 130);
  EXPECT_FALSE(std::filesystem::exists(out / "wall.ply")) << "it was not finished";
  bool is_torn = false;
  EXPECT_GT(frames_in(out / "wall.mcap", is_torn), 0u) << "what was recorded until a second ago is there";
}

TEST(Interrupted, RecordEndsWithAWholeFile) {
  EmulatedBus bus;
  const int address = bus.plug({});
  TempFolder out;
  Scan scan(bus, address, {"record", "-o", (out / "scan.mcap").string()}, out / "scan.mcap");
  const Outcome outcome = scan.interrupt_once();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  bool is_torn = true;
  EXPECT_GT(frames_in(out / "scan.mcap", is_torn), 0u);
  EXPECT_FALSE(is_torn);
}

TEST(Interrupted, RecordKeepsItsPicturesTheSecondTime) {
  EmulatedBus bus;
  const int address = bus.plug({});
  TempFolder out;
  Scan scan(bus, address, {"record", "-o", (out / "scan.mcap").string()}, out / "scan.mcap");
  const int exit_code = scan.interrupt_until_it_ends().exit_code;
  EXPECT_TRUE(exit_code == 130 || exit_code == 0) << exit_code << ": 0 when it was done before the second signal";
  bool is_torn = false;
  EXPECT_GT(frames_in(out / "scan.mcap", is_torn), 0u);
  EXPECT_TRUE(exit_code == 130 || !is_torn);
}

TEST(UdevRulesCommand, PrintsRules) {
  const Outcome outcome = scanknit_command({"udev-rules"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.out, "uaccess"));
}

TEST(UdevRulesCommand, PrintsThoseOfOneCamera) {
  const Outcome outcome = scanknit_command({"udev-rules", "--device", "1234:5678"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.out, "ATTR{idVendor}==\"1234\", ATTR{idProduct}==\"5678\"")) << outcome.out;
  EXPECT_FALSE(contains(outcome.out, "8086")) << outcome.out;
  EXPECT_EQ(scanknit_command({"udev-rules", "--device", "mine"}).exit_code, 2);
}

}  // namespace
}  // namespace scanknit::test
