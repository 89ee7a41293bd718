// The built program, looking at emulated cameras.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/usb/emulated/emulated_bus.h"

namespace scanknit::test {
namespace {

using nlohmann::json;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
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

TEST(UdevRulesCommand, PrintsRules) {
  const Outcome outcome = scanknit_command({"udev-rules"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.out, "uaccess"));
}

}  // namespace
}  // namespace scanknit::test
