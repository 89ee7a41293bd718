// What needs no USB: who holds a device, which streams are chosen, what the table of cameras says.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "acquire/device_rules.h"
#include "acquire/device_source.h"
#include "acquire/usb/device_holders.h"
#include "acquire/usb/quirks.h"
#include "acquire/uvc/transfer_ring.h"
#include "tests/core/temporary_folder.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

void add_process(const fs::path& proc, int process, const std::string& name, const fs::path& open_file) {
  const fs::path folder = proc / std::to_string(process);
  fs::create_directories(folder / "fd");
  std::ofstream(folder / "comm") << name << "\n";
  fs::create_symlink("/dev/null", folder / "fd" / "0");
  fs::create_symlink(open_file, folder / "fd" / "7");
}

TEST(DeviceHolders, AreFoundThroughTheirOpenFiles) {
  const TemporaryFolder proc;
  add_process(proc.path(), 812, "cheese", "/dev/video2");
  add_process(proc.path(), 900, "editor", "/home/a/text");
  add_process(proc.path(), 901, "(udev-worker)", "/dev/bus/usb/002/004");
  add_process(proc.path(), 77, "viewer", "/dev/bus/usb/002/004");
  const auto holders = find_holders({"/dev/bus/usb/002/004", "/dev/video2"}, proc.path());
  EXPECT_EQ(describe_holders(holders), "process 77 (viewer), process 812 (cheese)");
}

TEST(DeviceHolders, LookAtTheVideoNodesOfTheDevice) {
  const TemporaryFolder sys;
  fs::create_directories(sys.path() / "bus/usb/devices/2-1/2-1:1.0/video4linux/video2");
  fs::create_directories(sys.path() / "bus/usb/devices/2-1/2-1:1.3/video4linux/video4");
  fs::create_directories(sys.path() / "bus/usb/devices/2-1/power");
  auto nodes = device_nodes("/dev/bus/usb/002/004", "2-1", sys.path());
  std::sort(nodes.begin(), nodes.end());
  EXPECT_EQ(nodes, (std::vector<fs::path>{"/dev/bus/usb/002/004", "/dev/video2", "/dev/video4"}));
  EXPECT_EQ(device_nodes("/dev/bus/usb/002/004", "9-9", sys.path()).size(), 1u) << "gone in the meantime";
}

constexpr StreamProfile depth(int width, int height, double fps) {
  return {StreamKind::kDepth, PixelFormat::kZ16, width, height, fps};
}
constexpr StreamProfile colour(PixelFormat format, int width, int height, double fps) {
  return {StreamKind::kColour, format, width, height, fps};
}

TEST(ChooseStreams, TakesWhatWasAskedForAndColourToGoWithIt) {
  const std::vector<StreamProfile> offered = {depth(1280, 720, 30),
                                              depth(640, 480, 90),
                                              depth(640, 480, 30),
                                              colour(PixelFormat::kMjpeg, 640, 480, 30),
                                              colour(PixelFormat::kYuyv, 320, 240, 30),
                                              colour(PixelFormat::kYuyv, 640, 480, 30)};
  EXPECT_EQ(choose_streams(offered, 640, 480, 30), (std::vector<StreamProfile>{offered[2], offered[5]}));
  EXPECT_EQ(choose_streams(offered, 640, 480, 90)[0], offered[1]);
}

TEST(ChooseStreams, PrefersMoreToLess) {
  const std::vector<StreamProfile> offered = {depth(424, 240, 30), depth(848, 480, 30)};
  EXPECT_EQ(choose_streams(offered, 640, 480, 30), (std::vector<StreamProfile>{offered[1]}));
}

TEST(ChooseStreams, GivesNothingWithoutDepth) {
  EXPECT_TRUE(choose_streams(std::vector{colour(PixelFormat::kYuyv, 640, 480, 30)}, 640, 480, 30).empty());
}

TEST(Bandwidth, IsThatOfThePictures) {
  EXPECT_NEAR(bandwidth_of(std::vector{depth(640, 480, 30), colour(PixelFormat::kYuyv, 640, 480, 30)}), 36.864e6, 1);
}

TEST(TransferPlan, CoversATenthOfASecondWithinItsBudget) {
  constexpr std::size_t kFrame = 614400, kBudget = 6u << 20;
  const RingPlan whole = plan_bulk(0x82, 1024, kFrame + 12, kFrame, 30, kBudget);
  EXPECT_EQ(whole.transfer_bytes % 1024, 0u);
  EXPECT_GE(whole.transfer_bytes, kFrame + 12);
  EXPECT_EQ(whole.transfers, 4);
  const RingPlan small = plan_bulk(0x82, 1024, 16384, kFrame, 60, kBudget);
  EXPECT_EQ(small.transfers, 64);
  const RingPlan large = plan_bulk(0x82, 1024, 8'000'000, 8'000'000, 90, kBudget);
  EXPECT_LE(large.transfer_bytes * static_cast<std::size_t>(large.transfers), kBudget);
  EXPECT_GE(large.transfers, 2);
}

TEST(KnownCameras, KnowTheirUnits) {
  EXPECT_EQ(quirk_of(0x8086, 0x0b5b).depth_unit_m, 0.0001);  // D405
  EXPECT_EQ(quirk_of(0x8086, 0x0b07).depth_unit_m, 0.001);
  EXPECT_EQ(quirk_of(0x1234, 0x5678).vendor, 0);
}

TEST(UdevRules, GiveEachCameraToWhoSitsThereAndToNobodyElse) {
  const std::string rules = udev_rules();
  EXPECT_NE(rules.find("ATTR{idVendor}==\"8086\", ATTR{idProduct}==\"0b07\", MODE=\"0660\", TAG+=\"uaccess\""),
            std::string::npos);
  EXPECT_EQ(rules.find("0666"), std::string::npos);
}

TEST(UdevRules, AreMadeForACameraThatNoTableLists) {
  for (const char* device : {"1234:5a78", "usb:1234:5a78", "usb:1234:5a78/SERIAL", "1234:5A78"}) {
    const auto rules = udev_rules_for(device);
    ASSERT_TRUE(rules) << device;
    EXPECT_NE(rules->find("\nSUBSYSTEM==\"usb\", ATTR{idVendor}==\"1234\", ATTR{idProduct}==\"5a78\", MODE=\"0660\", "
                          "TAG+=\"uaccess\"\n"),
              std::string::npos)
        << *rules;
    EXPECT_EQ(rules->find("8086"), std::string::npos) << "of this camera only";
  }
}

TEST(UdevRules, AreRefusedForWhatNamesNoDevice) {
  for (const char* device : {"1234", "1234:", "1234:567", "1234:567g", "kinect1:0", "12345678", "usb:", "12\"4:5678"}) {
    const auto rules = udev_rules_for(device);
    ASSERT_FALSE(rules) << device;
    EXPECT_EQ(rules.error().code, ErrorCode::kUsage);
  }
}

TEST(UdevRules, AreAskedForByOneCommandWhichKeepsThoseOfOtherCameras) {
  EXPECT_EQ(rules_command(0x8086, 0x0b07),
            "scanknit udev-rules | sudo tee /etc/udev/rules.d/60-scanknit.rules && sudo udevadm control --reload");
  EXPECT_EQ(rules_command(0x045e, 0x02ae), rules_command(0x8086, 0x0b07)) << "a Kinect";
  EXPECT_EQ(rules_command(0x1234, 0x5a78),
            "scanknit udev-rules --device 1234:5a78 | sudo tee /etc/udev/rules.d/60-scanknit-1234-5a78.rules && "
            "sudo udevadm control --reload");
}

}  // namespace
}  // namespace scanknit::test
