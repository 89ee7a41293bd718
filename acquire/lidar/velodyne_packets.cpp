// By the user manuals of Velodyne: VLP-16 (63-9243 Rev. E, chapter 9), VLP-32C (63-9325 Rev. C, chapter 9) and HDL-32E
// (63-9113, chapter 9). 12 blocks of 100 bytes (a flag, the azimuth, 32 returns of 3 bytes), the time, and two factory
// bytes: the mode of returns and the model.
#include "acquire/lidar/velodyne_packets.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "core/rotation.h"

namespace scanknit {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kPacketBytes = 1206, kBlockBytes = 100, kBlocks = 12, kReturns = 32;
constexpr std::size_t kTimeAt = 1200, kReturnModeAt = 1204, kModelAt = 1205;
constexpr std::uint16_t kBlockFlag = 0xeeff, kLowerBankFlag = 0xddff;
constexpr std::uint8_t kDualReturn = 0x39;
constexpr int kTurn = 36000;  // azimuths are hundredths of a degree
constexpr std::int64_t kHour_ns = 3'600'000'000'000;

struct Laser {
  float elevation_deg = 0;
  float azimuth_offset_deg = 0;
  float rise_m = 0;  ///< of the beam's origin above the sensor's; the "vertical correction"
};

/// VLP-16 manual, table 9-1. Puck LITE is the same.
constexpr std::array<Laser, 16> kVlp16 = {{{-15, 0, 0.0112F},
                                           {1, 0, -0.0007F},
                                           {-13, 0, 0.0097F},
                                           {3, 0, -0.0022F},
                                           {-11, 0, 0.0081F},
                                           {5, 0, -0.0037F},
                                           {-9, 0, 0.0066F},
                                           {7, 0, -0.0051F},
                                           {-7, 0, 0.0051F},
                                           {9, 0, -0.0066F},
                                           {-5, 0, 0.0037F},
                                           {11, 0, -0.0081F},
                                           {-3, 0, 0.0022F},
                                           {13, 0, -0.0097F},
                                           {-1, 0, 0.0007F},
                                           {15, 0, -0.0112F}}};

/// The same table, Puck Hi-Res.
constexpr std::array<Laser, 16> kPuckHiRes = {{{-10, 0, 0.0074F},
                                               {0.67F, 0, -0.0009F},
                                               {-8.67F, 0, 0.0065F},
                                               {2, 0, -0.0018F},
                                               {-7.33F, 0, 0.0055F},
                                               {3.33F, 0, -0.0027F},
                                               {-6, 0, 0.0046F},
                                               {4.67F, 0, -0.0037F},
                                               {-4.67F, 0, 0.0037F},
                                               {6, 0, -0.0046F},
                                               {-3.33F, 0, 0.0027F},
                                               {7.33F, 0, -0.0055F},
                                               {-2, 0, 0.0018F},
                                               {8.67F, 0, -0.0065F},
                                               {-0.67F, 0, 0.0009F},
                                               {10, 0, -0.0074F}}};

/// VLP-32C manual, tables 9-2 and 9-6.
constexpr std::array<Laser, 32> kVlp32c = {
    {{-25, 1.4F},     {-1, -4.2F},      {-1.667F, 1.4F}, {-15.639F, -1.4F}, {-11.31F, 1.4F}, {0, -1.4F},
     {-0.667F, 4.2F}, {-8.843F, -1.4F}, {-7.254F, 1.4F}, {0.333F, -4.2F},   {-0.333F, 1.4F}, {-6.148F, -1.4F},
     {-5.333F, 4.2F}, {1.333F, -1.4F},  {0.667F, 4.2F},  {-4, -1.4F},       {-4.667F, 1.4F}, {1.667F, -4.2F},
     {1, 1.4F},       {-3.667F, -4.2F}, {-3.333F, 4.2F}, {3.333F, -1.4F},   {2.333F, 1.4F},  {-2.667F, -1.4F},
     {-3, 1.4F},      {7, -1.4F},       {4.667F, 1.4F},  {-2.333F, -4.2F},  {-2, 4.2F},      {15, -1.4F},
     {10.333F, 1.4F}, {-1.333F, -1.4F}}};

/// HDL-32E manual: the lasers of even numbers from -30.67 degrees up, those of odd numbers from -9.33, in steps of 4/3.
constexpr std::array<Laser, 32> hdl32e_lasers() {
  std::array<Laser, 32> lasers{};
  for (std::size_t i = 0; i < lasers.size(); ++i) {
    const float lowest = i % 2 == 0 ? -92 : -28;
    lasers[i].elevation_deg = (lowest + 4 * static_cast<float>(i / 2)) / 3;
  }
  return lasers;
}
constexpr std::array<Laser, 32> kHdl32e = hdl32e_lasers();

struct Model {
  std::uint8_t number = 0;  ///< the factory byte
  const char* name = "";
  std::span<const Laser> lasers;
  double unit_m = 0;     ///< of distances
  double step_us = 0;    ///< from shot to shot
  double firing_us = 0;  ///< from the first shot of all lasers to the next
  int lasers_at_once = 1;

  /// A block has 32 returns: two firings of 16 lasers.
  [[nodiscard]] double block_us() const { return firing_us * static_cast<double>(kReturns / lasers.size()); }

  /// After the block's first shot.
  [[nodiscard]] double shot_us(std::size_t index) const {
    const auto laser = static_cast<int>(index % lasers.size());
    return static_cast<double>(index / lasers.size()) * firing_us + laser / lasers_at_once * step_us;
  }
};

constexpr double kPuckStep_us = 2.304, kPuckFiring_us = 55.296;  // VLP-16 and VLP-32C manuals, section 9.4
constexpr double kHdlStep_us = 1.152, kHdlFiring_us = 46.08;     // HDL-32E manual, timing of shots
constexpr std::uint8_t kAlphaPrime = 0xa1;

constexpr std::array<Model, 4> kModels = {
    {{0x22, "velodyne_vlp16", kVlp16, 0.002, kPuckStep_us, kPuckFiring_us, 1},
     {0x24, "velodyne_puck_hi_res", kPuckHiRes, 0.002, kPuckStep_us, kPuckFiring_us, 1},
     {0x28, "velodyne_vlp32c", kVlp32c, 0.004, kPuckStep_us, kPuckFiring_us, 2},
     {0x21, "velodyne_hdl32e", kHdl32e, 0.002, kHdlStep_us, kHdlFiring_us, 1}}};

/// As if all blocks were of one packet.
class Blocks {
 public:
  explicit Blocks(Bytes packet) : packet_(packet) {}

  [[nodiscard]] bool is_dual() const { return little_endian_at<std::uint8_t>(packet_, kReturnModeAt) == kDualReturn; }
  [[nodiscard]] std::uint16_t flag(std::size_t block) const {
    return little_endian_at<std::uint16_t>(packet_, block * kBlockBytes);
  }
  [[nodiscard]] int azimuth(std::size_t block) const {
    return little_endian_at<std::uint16_t>(packet_, block * kBlockBytes + 2);
  }
  [[nodiscard]] std::uint16_t distance(std::size_t block, std::size_t index) const {
    return little_endian_at<std::uint16_t>(packet_, block * kBlockBytes + 4 + 3 * index);
  }
  [[nodiscard]] bool is_sound(std::size_t block) const { return flag(block) == kBlockFlag && azimuth(block) < kTurn; }

  /// How far the sensor turns from this block to the next firing; behind the last one as before it (manuals, section
  /// 9.5). 0 where azimuths do not fit together.
  [[nodiscard]] int turned(std::size_t block) const {
    const std::size_t step = is_dual() ? 2 : 1;  // two blocks are the two returns of one firing
    const std::size_t from = block + step < kBlocks ? block : block - step;
    constexpr int kMost = 1000;  // 20 turns a second are 0.8 degrees a block
    const int turned = (azimuth(from + step) - azimuth(from) + kTurn) % kTurn;
    return is_sound(from) && is_sound(from + step) && turned < kMost ? turned : 0;
  }

 private:
  Bytes packet_;
};

class VelodynePackets final : public LidarPackets {
 public:
  explicit VelodynePackets(const Model& model) : model_(model) {}

  [[nodiscard]] std::string name() const override { return model_.name; }
  [[nodiscard]] std::size_t blocks() const override { return kBlocks; }
  [[nodiscard]] std::int64_t clock_period_ns() const override { return kHour_ns; }
  [[nodiscard]] std::int64_t duration_ns() const override {
    return std::llround(1000 * model_.block_us() * static_cast<double>(kBlocks) / (is_dual_ ? 2 : 1));
  }

  [[nodiscard]] bool fits(Bytes packet) const override {
    return packet.size() == kPacketBytes && little_endian_at<std::uint16_t>(packet, 0) == kBlockFlag &&
           little_endian_at<std::uint8_t>(packet, kModelAt) == model_.number;
  }

  [[nodiscard]] std::optional<PacketHead> head(Bytes packet) override {
    const Blocks blocks(packet);
    is_dual_ = blocks.is_dual();
    PacketHead head{.clock_ns = std::int64_t{little_endian_at<std::uint32_t>(packet, kTimeAt)} * 1000 % kHour_ns};
    constexpr int kBack = kTurn / 4;  // less is a packet that comes late
    for (std::size_t block = 0; block < kBlocks; ++block) {
      if (!blocks.is_sound(block)) continue;
      if (blocks.azimuth(block) + kBack < azimuth_before_ && !head.turn_begins) head.turn_begins = block;
      azimuth_before_ = blocks.azimuth(block);
    }
    return head;
  }

  void add_points(Bytes packet, PacketBlocks range, std::int64_t offset_ns, Sweep& sweep) const override {
    const Blocks blocks(packet);
    for (std::size_t block = range.first; block < std::min(range.end, kBlocks); ++block) {
      if (blocks.is_sound(block)) add_block(blocks, block, offset_ns, sweep);
    }
  }

 private:
  void add_block(const Blocks& blocks, std::size_t block, std::int64_t offset_ns, Sweep& sweep) const {
    const std::size_t firing = blocks.is_dual() ? block / 2 : block;
    const bool is_second_return = blocks.is_dual() && block % 2 == 1;
    const double began_us = static_cast<double>(firing) * model_.block_us();
    const double turned = blocks.turned(block);
    for (std::size_t index = 0; index < kReturns; ++index) {
      const std::uint16_t distance = blocks.distance(block, index);
      if (distance == 0) continue;
      if (is_second_return && blocks.distance(block - 1, index) == distance) continue;  // there was only one
      const double shot_us = model_.shot_us(index);
      const double azimuth = blocks.azimuth(block) + turned * shot_us / model_.block_us();
      const std::size_t laser = index % model_.lasers.size();
      sweep.points_m.push_back(point(model_.lasers[laser], azimuth * 0.01, distance * model_.unit_m));
      sweep.rings.push_back(static_cast<std::uint16_t>(laser));
      sweep.offsets_ns.push_back(offset_ns + std::llround(1000 * (began_us + shot_us)));
    }
  }

  /// Manuals, sections 9.2 and 9.5. Their y axis, of azimuth 0, is forward; azimuths run clockwise.
  [[nodiscard]] static Eigen::Vector3f point(const Laser& laser, double azimuth_deg, double distance_m) {
    const double azimuth = (azimuth_deg + static_cast<double>(laser.azimuth_offset_deg)) * kDegree;
    const double elevation = static_cast<double>(laser.elevation_deg) * kDegree;
    const double level_m = distance_m * std::cos(elevation);
    return Eigen::Vector3d(level_m * std::cos(azimuth), -level_m * std::sin(azimuth),
                           distance_m * std::sin(elevation) + static_cast<double>(laser.rise_m))
        .cast<float>();
  }

  const Model& model_;
  int azimuth_before_ = 0;
  bool is_dual_ = false;
};

}  // namespace

std::optional<Result<std::unique_ptr<LidarPackets>>> velodyne_of(Bytes packet) {
  if (packet.size() != kPacketBytes || little_endian_at<std::uint16_t>(packet, 0) != kBlockFlag) return std::nullopt;
  if (little_endian_at<std::uint16_t>(packet, kBlockBytes) == kLowerBankFlag) {
    return Error{ErrorCode::kInput,
                 "packets of a Velodyne HDL-64E, which are not read: its lasers' angles are in the calibration file of "
                 "each sensor (db.xml). Convert the capture to KITTI's .bin files with their poses"};
  }
  const auto number = little_endian_at<std::uint8_t>(packet, kModelAt);
  for (const Model& model : kModels) {
    if (model.number == number) return std::unique_ptr<LidarPackets>(std::make_unique<VelodynePackets>(model));
  }
  return Error{
      ErrorCode::kInput,
      fmt::format("packets of {}, which are not read; expected a VLP-16, Puck LITE, Puck Hi-Res, VLP-32C or "
                  "HDL-32E. Convert the capture to KITTI's .bin files with their poses",
                  number == kAlphaPrime ? std::string("a Velodyne Alpha Prime (VLS-128)")
                                        : fmt::format("a Velodyne with the unknown model byte 0x{:02x}", number))};
}

}  // namespace scanknit
