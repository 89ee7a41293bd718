// What only a real system has: a kernel driver that wants the camera too, permissions, other users, the USB core's own
// opinion of our model.
#include <grp.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "acquire/device_rules.h"
#include "acquire/diagnose_devices.h"
#include "tests/app/program.h"
#include "tests/support/text.h"
#include "tests/usb/emulated/live_camera.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kPicturePixels = 640 * 480;  // of VcamOptions
constexpr std::size_t kPictureBytes = kPicturePixels * sizeof(std::uint16_t);
const VcamOptions kHighSpeed{.speed_mbit = 480};

/// What a shell's command prints, on both of its streams.
Outcome shell(const std::string& command) {
  Outcome outcome;
  std::FILE* pipe = popen(("( " + command + " ) 2>&1 </dev/null").c_str(), "r");
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) outcome.out += static_cast<char>(c);
  const int status = pclose(pipe);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

/// True: it happened within ten seconds.
template <typename Condition>
bool soon(const Condition& condition) {
  for (int i = 0; i < 100 && !condition(); ++i) std::this_thread::sleep_for(100ms);
  return condition();
}

/// The /dev/videoN that the kernel made for the depth function of the only camera; empty: none.
fs::path depth_video() {
  std::set<fs::path> found;
  for (const auto& interface : fs::directory_iterator("/sys/bus/usb/drivers/uvcvideo")) {
    std::error_code gone;
    const bool is_depth = interface.path().filename().string().ends_with(":1.0");
    fs::directory_iterator video(is_depth ? interface.path() / "video4linux" : fs::path(), gone);
    for (; video != fs::directory_iterator(); ++video) found.insert("/dev" / video->path().filename());
  }
  return found.empty() ? fs::path() : *found.begin();  // the next one is for metadata
}

/// Of the only camera.
bool has_finding(Finding::Grade grade, const std::string& part) {
  const auto diagnosis = diagnose_devices();
  if (!diagnosis || diagnosis->devices.size() != 1) return false;
  const auto& findings = diagnosis->devices.front().findings;
  return std::any_of(findings.begin(), findings.end(),
                     [&](const Finding& finding) { return finding.grade == grade && contains(finding.text, part); });
}

/// Streams depth with the kernel's driver and keeps the raw pictures.
std::string v4l2_client(int pictures, const fs::path& file) {
  return "timeout 60 v4l2-ctl -d " + depth_video().string() +
         " --stream-mmap --stream-count=" + std::to_string(pictures) + " --stream-to=" + file.string();
}

void skip_without_v4l2() {
  if (shell("command -v v4l2-ctl").exit_code != 0) GTEST_SKIP() << "v4l2-ctl is not there (Debian package v4l-utils)";
}

/// The pictures in a file of raw ones, by the numbers the camera gave them; damaged ones are failures.
std::vector<int> numbers_in(const fs::path& file) {
  const std::string bytes = read_text(file);
  EXPECT_EQ(bytes.size() % kPictureBytes, 0u);
  std::vector<int> numbers;
  for (std::size_t at = 0; at + kPictureBytes <= bytes.size(); at += kPictureBytes) {
    std::uint16_t number = 0;
    std::memcpy(&number, bytes.data() + at, sizeof(number));
    numbers.push_back(number);
    EXPECT_EQ(std::memcmp(bytes.data() + at, Vcam::depth_pixels(number, kPicturePixels).data(), kPictureBytes), 0)
        << number;
  }
  return numbers;
}

struct KernelStream {
  const char* name;
  VcamOptions options;
};

void PrintTo(const KernelStream& stream, std::ostream* out) {
  *out << stream.name;
}

/// A second opinion of our model: the kernel's own driver.
class KernelDriver : public ::testing::TestWithParam<KernelStream> {
 protected:
  void SetUp() override { skip_without_v4l2(); }
};

TEST_P(KernelDriver, StreamsTheModelsPictures) {
  EmulatedBus bus;
  const TempFolder folder;
  bus.plug(GetParam().options);
  ASSERT_FALSE(depth_video().empty());
  EXPECT_TRUE(contains(shell("v4l2-ctl -d " + depth_video().string() + " --get-fmt-video").out, "'Z16 '"));
  const Outcome client = shell(v4l2_client(20, folder / "depth"));
  EXPECT_EQ(client.exit_code, 0) << client.out;
  const auto numbers = numbers_in(folder / "depth");
  ASSERT_EQ(numbers.size(), 20u) << client.out;
  // v4l2-ctl may lose whole pictures here, where writing them takes long.
  EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end(), std::less_equal<>()));
}

INSTANTIATE_TEST_SUITE_P(All, KernelDriver,
                         ::testing::Values(KernelStream{"WholePictures", {}},
                                           KernelStream{"SmallPayloads", {.payload_bytes = 16384}},
                                           KernelStream{"Uvc10", {.uvc_version = 0x0100}},
                                           KernelStream{"HighSpeed", kHighSpeed},
                                           KernelStream{"Isochronous", {.is_isochronous = true, .speed_mbit = 480}}),
                         [](const auto& test) { return test.param.name; });

TEST(KernelDriver, IsPutAsideWhileWeStreamAndComesBack) {
  EmulatedBus bus;
  FrameLog log;
  bus.plug({});
  ASSERT_FALSE(depth_video().empty());
  {
    const auto source = open_first();
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_TRUE(depth_video().empty());
    ASSERT_TRUE((*source)->start(streams_of(**source, EmulatedBus::kBriskFps), log.frame_sink(), log.event_sink()));
    EXPECT_TRUE(log.wait_for_depth(5));
  }
  EXPECT_TRUE(soon([] { return !depth_video().empty(); }));
}

/// A camera whose pictures another program streams.
class CameraInUse : public ::testing::Test {
 protected:
  void SetUp() override {
    skip_without_v4l2();
    if (IsSkipped()) return;
    address = bus.plug({});
    bus.with_camera(address,
                    [](Vcam& camera) { camera.depth_waits_at = 20; });  // until the other program was looked at
    client = std::jthread([this, command = v4l2_client(40, folder / "depth")] { outcome = shell(command); });
    EXPECT_TRUE(soon([this] { return fs::exists(folder / "depth") && fs::file_size(folder / "depth") > 0; }));
  }

  void let_go() {
    bus.with_camera(address, [](Vcam& camera) { camera.depth_waits_at = Vcam::kNever; });
  }

  EmulatedBus bus;
  int address = 0;
  TempFolder folder;
  Outcome outcome;
  std::jthread client;
};

TEST_F(CameraInUse, IsLeftAloneAndItsHolderNamed) {
  const auto ours = open_first();
  ASSERT_FALSE(ours);
  EXPECT_TRUE(contains(ours.error().message, "(v4l2-ctl)")) << ours.error().text();
  EXPECT_TRUE(has_finding(Finding::Grade::kProblem, "(v4l2-ctl)"));
  let_go();
  client.join();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_EQ(numbers_in(folder / "depth").size(), 40u);
}

TEST_F(CameraInUse, IsTakenByForce) {
  let_go();
  DeviceOptions options;
  options.takes_from_others = true;
  FrameLog log;
  const auto ours = open_first(options);
  ASSERT_TRUE(ours) << ours.error().text();
  ASSERT_TRUE((*ours)->start(streams_of(**ours, EmulatedBus::kBriskFps), log.frame_sink(), log.event_sink()));
  EXPECT_TRUE(log.wait_for_depth(5));
  client.join();
  EXPECT_LT(numbers_in(folder / "depth").size(), 40u);
}

TEST(Program, RecordsARealDevice) {
  EmulatedBus bus;
  const TempFolder folder;
  bus.plug({});
  const Outcome recorded =
      scanknit_command({"record", "--json", "--fps", "15", "--frames", "30", "-o", folder / "r.mcap"});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const json losses = json::parse(recorded.out).at("losses");
  EXPECT_EQ(losses.at("device"), 0);
  EXPECT_EQ(losses.at("transport"), 0);
  EXPECT_EQ(losses.at("overflow"), 0);
  const Outcome info = scanknit_command({"info", "--json", folder / "r.mcap"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  EXPECT_GE(json::parse(info.out).at("frames"), 30);
}

TEST(Program, ExaminesARealDevice) {
  EmulatedBus bus;
  bus.plug(kHighSpeed);
  const Outcome outcome = scanknit_command({"doctor"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* line : {"usb:8086:0b07/0123456789ab", "the kernel has uvcvideo bound", "note     link: 480 Mbit/s",
                           "ok       permission", "ok       USB memory: 16 MB"}) {
    EXPECT_TRUE(contains(outcome.out, line)) << line << "\n" << outcome.out;
  }
}

TEST(Doctor, FindsACameraThatWasNotSetUp) {
  EmulatedBus bus;
  bus.plug({});
  for (const auto& device : fs::directory_iterator("/sys/bus/usb/devices")) {
    if (contains(read_text(device.path() / "idVendor"), "8086")) {
      std::ofstream(device.path() / "bConfigurationValue") << -1;
    }
  }
  EXPECT_TRUE(has_finding(Finding::Grade::kProblem, "configuration: "));
}

/// Somebody who is not root. udev is told (init) that it is `nobody` who sits at this computer.
class OrdinaryUser : public ::testing::Test {
 protected:
  ~OrdinaryUser() override {
    fs::remove(kRules);
    (void)shell("udevadm control --reload");
  }
  /// Calls `act` as nobody; the whole process is nobody for so long.
  template <typename Act>
  static void as_nobody(const Act& act) {
    constexpr uid_t kNobody = 65534;
    ASSERT_EQ(setgroups(0, nullptr), 0);
    ASSERT_EQ(setresgid(kNobody, kNobody, 0), 0);
    ASSERT_EQ(setresuid(kNobody, kNobody, 0), 0);
    act();
    ASSERT_EQ(setresuid(0, 0, 0), 0);
    ASSERT_EQ(setresgid(0, 0, 0), 0);
  }

  inline static const fs::path kRules = "/run/udev/rules.d/60-scanknit.rules";
  EmulatedBus bus;
};

TEST_F(OrdinaryUser, WithoutOurRulesIsToldOfThem) {
  bus.plug({});
  as_nobody([] {
    const auto source = open_first();
    ASSERT_FALSE(source);
    EXPECT_TRUE(contains(source.error().message, "scanknit udev-rules")) << source.error().text();
    EXPECT_TRUE(has_finding(Finding::Grade::kProblem, "permission: "));
  });
}

TEST_F(OrdinaryUser, WithOurRulesMayScan) {
  std::ofstream(kRules) << udev_rules();
  EXPECT_EQ(shell("udevadm settle && udevadm control --reload").exit_code, 0);
  bus.plug({});
  as_nobody([] {
    FrameLog log;
    DeviceOptions options;
    options.wait_s = 30;  // until udev has come to it
    const auto source = open_first(options);
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_TRUE(has_finding(Finding::Grade::kGood, "permission: "));
    ASSERT_TRUE((*source)->start(streams_of(**source, EmulatedBus::kBriskFps), log.frame_sink(), log.event_sink()));
    EXPECT_TRUE(log.wait_for_depth(5));
  });
}

TEST_F(OrdinaryUser, OfACameraThatNoTableListsIsToldOfTheRulesForIt) {
  bus.plug({.vendor = 0x1234, .product = 0x5678, .has_metadata = false, .depth_code = "Y16 "});
  as_nobody([] {
    const std::string command = "scanknit udev-rules --device 1234:5678 | sudo tee";
    const auto source = open_first();
    ASSERT_FALSE(source);
    EXPECT_TRUE(contains(source.error().message, command)) << source.error().text();
    const auto diagnosis = diagnose_devices();
    ASSERT_TRUE(diagnosis && diagnosis->devices.size() == 1);
    const auto& findings = diagnosis->devices.front().findings;
    EXPECT_TRUE(std::ranges::any_of(findings, [&](const Finding& each) { return contains(each.remedy, command); }));
  });
}

TEST_F(OrdinaryUser, MayUseACameraThatNoTableListsWithTheRulesForIt) {
  std::ofstream(kRules) << udev_rules_for("1234:5678").value();
  EXPECT_EQ(shell("udevadm settle && udevadm control --reload").exit_code, 0);
  bus.plug({.vendor = 0x1234, .product = 0x5678, .has_metadata = false, .depth_code = "Y16 "});
  as_nobody([] {
    DeviceOptions options;
    options.wait_s = 30;  // until udev has come to it
    const auto source = open_first(options);
    EXPECT_TRUE(source) << source.error().text();
  });
}

}  // namespace
}  // namespace scanknit::test
