// Captures of Velodyne's and Ouster's packets become sweeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "acquire/lidar/ouster_packets.h"
#include "acquire/lidar/pcap_file.h"
#include "acquire/lidar/pcap_sweeps.h"
#include "acquire/lidar/sweep_source.h"
#include "tests/acquire/lidar_packets.h"
#include "tests/core/temporary_folder.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr double kBegan_s = 1'700'000'100;  // in November 2023; 900 seconds after a full hour
constexpr double kHourClock_s = 900;        // of it; what a Velodyne with GPS counts
static_assert(1'700'000'100 % 3600 == 900);

/// Writes the capture as walk.pcap with its trajectory, and opens it.
Result<std::unique_ptr<SweepSource>> opened_capture(const fs::path& folder, const std::string& capture,
                                                    const std::string& metadata = "", double poses_began_s = kBegan_s) {
  write_whole(folder / "walk.pcap", capture);
  write_walk(folder / "poses.txt", poses_began_s);
  if (!metadata.empty()) write_whole(folder / "walk.json", metadata);
  return open_sweeps(folder / "walk.pcap", {});
}

/// All sweeps that can be used.
std::vector<Sweep> sweeps_of(SweepSource& source) {
  std::vector<Sweep> sweeps;
  for (std::size_t i = 0; i < source.info().sweeps; ++i) {
    auto event = source.read(i);
    if (auto* sweep = std::get_if<Sweep>(&event)) sweeps.push_back(std::move(*sweep));
  }
  return sweeps;
}

std::size_t count_points(const std::vector<Sweep>& sweeps) {
  std::size_t points = 0;
  for (const Sweep& sweep : sweeps) points += sweep.points_m.size();
  return points;
}

double worst_off_walls_m(const std::vector<Sweep>& sweeps) {
  double worst = 0;
  for (const Sweep& sweep : sweeps) {
    for (const auto& p : sweep.points_m) worst = std::max(worst, off_walls_m(sweep.T_world_sensor * p.cast<double>()));
  }
  return worst;
}

bool has_warning(const SweepInfo& info, const std::string& text) {
  return std::any_of(info.warnings.begin(), info.warnings.end(),
                     [&](const std::string& warning) { return warning.find(text) != std::string::npos; });
}

/// A little more than two turns of a VLP-16, from an azimuth of 120 degrees on.
std::vector<SentPacket> vlp16_walk(double clock_s = kHourClock_s) {
  return velodyne_packets(WrittenVelodyne::vlp16(), 170, clock_s, 300);
}

class VelodyneCapture : public ::testing::TestWithParam<WrittenVelodyne> {};

TEST_P(VelodyneCapture, OfAMovingScannerHasItsPointsOnTheWalls) {
  const WrittenVelodyne& model = GetParam();
  const test::TemporaryFolder folder;
  const int packets = 2 * 36000 / model.step / model.firings() + 20;
  const auto source =
      opened_capture(folder.path(), capture_bytes(velodyne_packets(model, packets, kHourClock_s), kBegan_s));
  ASSERT_TRUE(source) << source.error().text();
  const SweepInfo& info = (*source)->info();
  EXPECT_EQ(info.sweeps, 3u) << "two turns, and a part of the next";
  EXPECT_EQ(info.sweeps_with_pose, 3u);
  EXPECT_EQ(info.world_up, UpAxis::kZ);
  EXPECT_TRUE(info.warnings.empty()) << info.warnings.front();
  const auto sweeps = sweeps_of(**source);
  ASSERT_EQ(sweeps.size(), 3u);
  EXPECT_EQ(count_points(sweeps), static_cast<std::size_t>(packets * 12 * 32)) << "each shot once";
  // Half a unit is rounding; the float and the straight pieces of the motion are below a tenth of a millimetre.
  EXPECT_LT(worst_off_walls_m(sweeps), model.unit_m / 2 + 1e-4);
  EXPECT_NEAR(static_cast<double>(*sweeps[0].timestamp_ns) * 1e-9, kBegan_s, 1e-5);
}

TEST_P(VelodyneCapture, NamesTheLaserOfEachPoint) {
  const WrittenVelodyne& model = GetParam();
  const test::TemporaryFolder folder;
  // The walk's poses stand still here, so that elevations are the lasers'.
  write_whole(folder / "a.pcap", capture_bytes(velodyne_packets(model, 20, kHourClock_s), kBegan_s));
  write_whole(folder / "a.tum", "1700000099 0 0 0 0 0 0 1\n1700000099.95 0 0 0 0 0 0 1\n1700000100.15 0 0 0 0 0 0 1\n");
  const auto source = open_sweeps(folder / "a.pcap", {});
  ASSERT_TRUE(source) << source.error().text();
  const auto sweeps = sweeps_of(**source);
  ASSERT_EQ(sweeps.size(), 1u);
  std::set<int> lasers;
  for (std::size_t i = 0; i < sweeps[0].points_m.size(); ++i) {
    const int laser = sweeps[0].rings[i];
    const Eigen::Vector3d p = sweeps[0].points_m[i].cast<double>() - Eigen::Vector3d(0, 0, model.rise_m(laser));
    const double elevation = std::atan2(p.z(), std::hypot(p.x(), p.y())) * 180 / std::numbers::pi;
    ASSERT_NEAR(elevation, model.elevation_deg(laser), 0.001) << laser;
    lasers.insert(laser);
  }
  EXPECT_EQ(lasers.size(), static_cast<std::size_t>(model.lasers));
}

INSTANTIATE_TEST_SUITE_P(Models, VelodyneCapture,
                         ::testing::Values(WrittenVelodyne::vlp16(), WrittenVelodyne::vlp32c(),
                                           WrittenVelodyne::hdl32e()));

TEST(VelodyneReturns, AreBothReadWhereTheyDiffer) {
  WrittenVelodyne model = WrittenVelodyne::vlp16();
  model.is_dual = true;
  const test::TemporaryFolder folder;
  const auto source =
      opened_capture(folder.path(), capture_bytes(velodyne_packets(model, 320, kHourClock_s), kBegan_s));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sweeps, 3u);
  EXPECT_TRUE((*source)->info().warnings.empty());
  const auto sweeps = sweeps_of(**source);
  std::size_t on_walls = 0, points = count_points(sweeps);
  for (const Sweep& sweep : sweeps) {
    for (const auto& p : sweep.points_m) on_walls += off_walls_m(sweep.T_world_sensor * p.cast<double>()) < 0.0011;
  }
  const std::size_t shots = 320 * 6 * 32;
  EXPECT_EQ(points, shots * 3 / 2) << "half of the shots have two returns";
  EXPECT_GE(on_walls, shots);
}

TEST(VelodyneClock, GoesOnOverTheFullHour) {
  const test::TemporaryFolder folder;
  const double began_s = kBegan_s + 2700 - 0.12;  // in the second sweep the hour is full
  const auto source = opened_capture(folder.path(), capture_bytes(vlp16_walk(3600 - 0.12), began_s), "", began_s);
  ASSERT_TRUE(source) << source.error().text();
  const auto sweeps = sweeps_of(**source);
  ASSERT_EQ(sweeps.size(), 3u);
  EXPECT_LT(worst_off_walls_m(sweeps), 0.0011);
  EXPECT_NEAR(*(*source)->info().duration_s, 0.166, 0.002);
}

TEST(VelodyneClock, ThatNobodySetIsReplacedByTheComputers) {
  const test::TemporaryFolder folder;
  const auto source = opened_capture(folder.path(), capture_bytes(vlp16_walk(2000), kBegan_s));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_TRUE(has_warning((*source)->info(), "computer's time")) << (*source)->info().warnings.size();
  const auto sweeps = sweeps_of(**source);
  ASSERT_EQ(sweeps.size(), 3u);
  // A packet is captured up to 2 ms after its first shot, in which the scanner moves 4 mm and turns 1 mrad.
  EXPECT_LT(worst_off_walls_m(sweeps), 0.015);
}

TEST(VelodyneClock, IsTakenWhereOnlyItMeetsTheTrajectory) {
  const test::TemporaryFolder folder;  // the computer's clock is 100 s late; the sensor's is GPS's
  const auto source = opened_capture(folder.path(), capture_bytes(vlp16_walk(), kBegan_s - 100));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sweeps_with_pose, 3u);
  EXPECT_LT(worst_off_walls_m(sweeps_of(**source)), 0.0011);
}

TEST(LostPackets, LeaveAGapInASweepAndAreTold) {
  const test::TemporaryFolder folder;
  WrittenCapture form;
  form.keeps = [](int record) { return record < 80 || record > 90; };
  const auto source = opened_capture(folder.path(), capture_bytes(vlp16_walk(), kBegan_s, form));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sweeps, 3u);
  EXPECT_TRUE(has_warning((*source)->info(), "packets are missing in 1 of 3 sweeps"));
  const auto sweeps = sweeps_of(**source);
  EXPECT_EQ(count_points(sweeps), (170u - 11) * 12 * 32);
  EXPECT_LT(worst_off_walls_m(sweeps), 0.0011);
}

TEST(LostPackets, WhereATurnEndsDoNotJoinTwoSweeps) {
  const test::TemporaryFolder folder;
  WrittenCapture form;
  form.keeps = [](int record) { return record < 45 || record > 55; };  // 0 degrees is in packet 50
  const auto source = opened_capture(folder.path(), capture_bytes(vlp16_walk(), kBegan_s, form));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sweeps, 3u);
}

struct OusterCase {
  WrittenOuster model;
  double bound_m = 0;
};

class OusterCapture : public ::testing::TestWithParam<OusterCase> {};

TEST_P(OusterCapture, OfAMovingScannerHasItsPointsOnTheWalls) {
  const auto& [model, bound_m] = GetParam();
  const test::TemporaryFolder folder;
  WrittenCapture form;
  form.mtu = 1500;
  const auto packets = ouster_packets_of(model, 2, kBegan_s);
  const auto source = opened_capture(folder.path(), capture_bytes(packets, kBegan_s, form), model.json());
  ASSERT_TRUE(source) << source.error().text();
  const SweepInfo& info = (*source)->info();
  EXPECT_EQ(info.sweeps, 2u);
  EXPECT_EQ(info.sweeps_with_pose, 2u);
  EXPECT_TRUE(info.warnings.empty()) << info.warnings.front();
  const auto sweeps = sweeps_of(**source);
  const std::size_t shots = static_cast<std::size_t>(2 * model.columns * model.beams);
  if (model.profile.ends_with("_DUAL")) {
    EXPECT_EQ(count_points(sweeps), 2 * shots);
    return;
  }
  EXPECT_EQ(count_points(sweeps), shots);
  EXPECT_LT(worst_off_walls_m(sweeps), bound_m);
  for (std::size_t i = 0; i < sweeps[0].rings.size(); ++i) {
    ASSERT_EQ(sweeps[0].rings[i], i % static_cast<std::size_t>(model.beams));
  }
}

// Half a unit is rounding: ranges are in millimetres, or in 8 of them, which the writer rounds after millimetres.
INSTANTIATE_TEST_SUITE_P(
    Profiles, OusterCapture,
    ::testing::Values(OusterCase{{"LEGACY", 64}, 0.0006}, OusterCase{{"LEGACY", 128, 256}, 0.0006},
                      OusterCase{{"RNG19_RFL8_SIG16_NIR16", 64, 256, 16, 10, 27.67, true}, 0.0006},
                      OusterCase{{"RNG19_RFL8_SIG16_NIR16", 128, 256, 8, 20, 13.762, true}, 0.0006},
                      OusterCase{{"RNG15_RFL8_NIR8", 128, 256, 16, 10, 15.806, true}, 0.0046},
                      OusterCase{{"RNG19_RFL8_SIG16_NIR16_DUAL", 32, 256, 16, 10, 27.67, false}, 0}));

TEST(OusterClock, ThatCountsFromPowerOnIsReplacedByTheComputers) {
  const WrittenOuster model{.beams = 16, .columns = 256};
  const test::TemporaryFolder folder;
  const auto source =
      opened_capture(folder.path(), capture_bytes(ouster_packets_of(model, 2, 77), kBegan_s), model.json());
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sweeps_with_pose, 2u);
  EXPECT_TRUE(has_warning((*source)->info(), "computer's time"));
}

TEST(OusterMetadataFile, FitsByItsNameOrByThePacketsItTellsOf) {
  const WrittenOuster model{.beams = 16, .columns = 256}, other{.beams = 32, .columns = 256};
  const test::TemporaryFolder folder;
  const std::string capture = capture_bytes(ouster_packets_of(model, 1, kBegan_s), kBegan_s);
  write_whole(folder / "another.json", other.json());
  auto source = opened_capture(folder.path(), capture);
  ASSERT_FALSE(source);
  const std::string message = source.error().text();
  EXPECT_NE(message.find("16 of 3392 bytes to port 7502"), std::string::npos) << message;
  EXPECT_NE(message.find("walk.json"), std::string::npos) << message;
  EXPECT_NE(message.find("another.json: packets have 6464 bytes"), std::string::npos) << message;
  write_whole(folder / "sensor.json", model.json());
  source = open_sweeps(folder / "walk.pcap", {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "ouster");
}

TEST(OusterMetadataFile, OfOddContentIsAnError) {
  const std::string sound = WrittenOuster{.beams = 16}.json();
  ASSERT_TRUE(parse_ouster_metadata(sound));
  for (std::size_t size = 0; size < sound.size(); ++size) EXPECT_FALSE(parse_ouster_metadata(sound.substr(0, size)));
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string text = sound;
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos);
    return parse_ouster_metadata(text.replace(at, what.size(), instead));
  };
  EXPECT_FALSE(with("\"columns_per_frame\": 512", "\"columns_per_frame\": 1e300"));
  EXPECT_FALSE(with("\"columns_per_packet\": 16", "\"columns_per_packet\": -1"));
  EXPECT_FALSE(with("\"pixels_per_column\": 16", "\"pixels_per_column\": 17"));
  EXPECT_FALSE(with("[-1, 0, 0, 0, 0, -1", "[-2, 0, 0, 0, 0, -1"));
  EXPECT_FALSE(with("16.6", "\"16.6\""));
  const auto fusa = with("LEGACY", "FUSA_RNG15_RFL8_NIR8_DUAL");
  ASSERT_FALSE(fusa);
  EXPECT_NE(fusa.error().message.find("FUSA_RNG15_RFL8_NIR8_DUAL"), std::string::npos);
}

TEST(Fragments, ThatAreMissingCostTheirPacketAndAreTold) {
  const WrittenOuster model{.beams = 64, .columns = 256};
  const test::TemporaryFolder folder;
  WrittenCapture form;
  form.mtu = 1500;
  form.keeps = [](int record) { return record != 40; };
  const auto source =
      opened_capture(folder.path(), capture_bytes(ouster_packets_of(model, 2, kBegan_s), kBegan_s, form), model.json());
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_TRUE(has_warning((*source)->info(), "1 packets are not read because fragments"));
  EXPECT_EQ(count_points(sweeps_of(**source)), static_cast<std::size_t>((2 * 256 - 16) * 64));
}

class CaptureForm : public ::testing::TestWithParam<WrittenCapture> {};

TEST_P(CaptureForm, DoesNotChangeWhatIsRead) {
  const test::TemporaryFolder folder;
  const auto source = opened_capture(folder.path(), capture_bytes(vlp16_walk(), kBegan_s, GetParam()));
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_TRUE((*source)->info().warnings.empty());
  const auto sweeps = sweeps_of(**source);
  EXPECT_EQ(count_points(sweeps), 170u * 12 * 32);
  EXPECT_LT(worst_off_walls_m(sweeps), 0.0011);
}

INSTANTIATE_TEST_SUITE_P(Forms, CaptureForm,
                         ::testing::Values(WrittenCapture{}, WrittenCapture{.has_ns = true},
                                           WrittenCapture{.is_big_endian = true},
                                           WrittenCapture{.is_big_endian = true, .has_ns = true},
                                           WrittenCapture{.is_pcapng = true},
                                           WrittenCapture{.is_pcapng = true, .has_ns = true},
                                           WrittenCapture{.is_pcapng = true, .is_big_endian = true},
                                           WrittenCapture{.link = WrittenCapture::Link::kVlan},
                                           WrittenCapture{.link = WrittenCapture::Link::kCooked},
                                           WrittenCapture{.link = WrittenCapture::Link::kCooked2},
                                           WrittenCapture{.link = WrittenCapture::Link::kRaw, .mtu = 576}));

TEST(CaptureWithoutLidar, SaysWhatIsInIt) {
  const test::TemporaryFolder folder;
  const std::string capture =
      capture_bytes({{0, "hello", 53}, {0.1, "hello", 53}, {0.2, std::string(700, 'x'), 5004}}, kBegan_s);
  const auto source = opened_capture(folder.path(), capture);
  ASSERT_FALSE(source);
  const std::string message = source.error().text();
  EXPECT_NE(message.find("walk.pcap"), std::string::npos) << message;
  EXPECT_NE(message.find("2 of 5 bytes to port 53, 1 of 700 bytes to port 5004"), std::string::npos) << message;
  EXPECT_NE(message.find("1206 bytes"), std::string::npos) << message;
  EXPECT_TRUE(is_sweep_recording(folder / "walk.pcap", {}));
  EXPECT_FALSE(is_sweep_recording(folder / "poses.txt", {}));
}

TEST(CaptureOfAnUnknownModel, SaysWhy) {
  const test::TemporaryFolder folder;
  auto packets = velodyne_packets(WrittenVelodyne::hdl32e(), 2, kHourClock_s);
  for (SentPacket& packet : packets) packet.payload.back() = static_cast<char>(0xa1);
  auto source = opened_capture(folder.path(), capture_bytes(packets, kBegan_s));
  ASSERT_FALSE(source);
  EXPECT_NE(source.error().text().find("VLS-128"), std::string::npos) << source.error().text();
  for (SentPacket& packet : packets) packet.payload[101] = static_cast<char>(0xdd);
  source = opened_capture(folder.path(), capture_bytes(packets, kBegan_s));
  ASSERT_FALSE(source);
  EXPECT_NE(source.error().text().find("calibration file"), std::string::npos) << source.error().text();
}

TEST(CaptureWithoutPoses, IsOpenedAndAllSweepsAreDropped) {
  const test::TemporaryFolder folder;
  write_whole(folder / "a.pcap", capture_bytes(vlp16_walk(), kBegan_s));
  auto source = open_sweeps(folder / "a.pcap", {});
  EXPECT_TRUE(open_sweeps(folder.path(), {})) << "its folder";
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sweeps, 3u);
  EXPECT_EQ((*source)->info().sweeps_with_pose, 0u);
  EXPECT_NE((*source)->info().expected_poses.find("a.tum"), std::string::npos);
  const auto event = (*source)->read(1);
  ASSERT_TRUE(std::holds_alternative<FrameDropped>(event));
  EXPECT_EQ(std::get<FrameDropped>(event).reason, DropReason::kNoPose);
  write_walk(folder / "trajectory.txt", kBegan_s - 5000);
  source = open_sweeps(folder / "a.pcap", {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().sweeps_with_pose, 0u);
  EXPECT_NE((*source)->info().expected_poses.find("No sweep lies within"), std::string::npos);
  EXPECT_TRUE(sweeps_of(**source).empty());
  write_whole(folder / "trajectory.txt", "x 0 0 0 0 0 0 1\n");
  EXPECT_FALSE(open_sweeps(folder / "a.pcap", {})) << "a trajectory that is none";
}

/// Opens the capture, whose other files are there, and reads all of it. Returns how many points there were.
std::size_t points_of_capture(const fs::path& folder, const std::string& capture) {
  const auto file = std::as_bytes(std::span(capture));
  const auto source = open_pcap_sweeps(std::make_unique<MemoryAccess>(file), folder / "walk.pcap", {});
  return source ? count_points(sweeps_of(**source)) : 0;
}

struct DamagedCase {
  std::vector<SentPacket> packets;
  WrittenCapture form;
  std::string metadata;
  std::size_t points = 0;
};

std::vector<DamagedCase> damaged_cases() {
  const WrittenOuster ouster{.profile = "RNG19_RFL8_SIG16_NIR16", .beams = 4, .columns = 16, .in_packet = 8};
  WrittenCapture fragments{.is_pcapng = true};
  fragments.mtu = 200;
  return {{velodyne_packets(WrittenVelodyne::vlp16(), 2, kHourClock_s, 890), {}, "", 2 * 12 * 32},
          {ouster_packets_of(ouster, 2, kBegan_s), fragments, ouster.json(), 2 * 16 * 4}};
}

TEST(DamagedCapture, CutAtEveryByteHasAtMostItsPoints) {
  const test::TemporaryFolder folder;
  for (const DamagedCase& damaged : damaged_cases()) {
    const std::string whole = capture_bytes(damaged.packets, kBegan_s, damaged.form);
    ASSERT_TRUE(opened_capture(folder.path(), whole, damaged.metadata));
    ASSERT_EQ(points_of_capture(folder.path(), whole), damaged.points);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      ASSERT_LE(points_of_capture(folder.path(), whole.substr(0, size)), damaged.points) << size;
    }
    const auto source = opened_capture(folder.path(), whole.substr(0, whole.size() - 1), damaged.metadata);
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_TRUE(has_warning((*source)->info(), "cut off"));
  }
}

TEST(DamagedCapture, WithChangedBytesIsReadOrRefused) {
  const test::TemporaryFolder folder;
  std::mt19937 random(11);
  for (const DamagedCase& damaged : damaged_cases()) {
    const std::string whole = capture_bytes(damaged.packets, kBegan_s, damaged.form);
    ASSERT_TRUE(opened_capture(folder.path(), whole, damaged.metadata));
    for (int i = 0; i < 1000; ++i) {
      std::string changed = whole;
      for (int k = 0; k <= i % 4; ++k) changed[random() % changed.size()] = static_cast<char>(random());
      ASSERT_LE(points_of_capture(folder.path(), changed), damaged.points) << i;
    }
  }
}

TEST(CaptureOfAnotherProgram, IsReadPacketByPacket) {
  const test::TemporaryFolder folder;
  const std::string script = kSourceDir + "/tests/acquire/write_scapy_pcap.py";
  for (const std::string name : {"a.pcap", "a.pcapng"}) {
    const std::string command = "/usr/bin/python3 '" + script + "' '" + (folder / name).string() + "' 2>/dev/null";
    const int status = std::system(command.c_str());
    if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "SKIPPED: python3-scapy is not installed";
    ASSERT_EQ(status, 0) << command;
    auto file = open_random_access(folder / name);
    ASSERT_TRUE(file);
    auto records = PcapRecords::open(*std::move(file));
    ASSERT_TRUE(records) << records.error().text();
    UdpDatagrams datagrams(*std::move(records));
    int count = 0;
    for (; const auto datagram = datagrams.next(); ++count) {
      const std::size_t size = 100 + 3000 * static_cast<std::size_t>(count);
      ASSERT_EQ(datagram->payload.size(), size);
      EXPECT_EQ(datagram->port, 7000 + count);
      EXPECT_EQ(datagram->source, 0x0a000001u);
      EXPECT_NEAR(static_cast<double>(datagram->time_ns) * 1e-9, 1'700'000'000.25 + count, 1e-6);
      for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(std::to_integer<std::size_t>(datagram->payload[i]), i * 7 % 251);
    }
    EXPECT_EQ(count, 5) << name;
    EXPECT_TRUE(datagrams.records().damage().empty());
  }
}

}  // namespace
}  // namespace scanknit
