#include "acquire/lidar/pcap_sweeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/lidar/ouster_packets.h"
#include "acquire/lidar/pcap_file.h"
#include "acquire/lidar/undo_motion.h"
#include "acquire/lidar/velodyne_packets.h"
#include "acquire/parse/timed_poses.h"
#include "acquire/replay/folder.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kOneSecond_ns = 1'000'000'000;
constexpr std::int64_t kPause_ns = 1'500'000'000;           // no sweep takes so long
constexpr std::size_t kMostSweepPackets = 8192;             // 3 million points; the largest sweeps have 260,000
constexpr std::int64_t kPoseGap_ns = 250'000'000;           // a trajectory of 10 poses a second, some of them missing
constexpr std::int64_t kSameClock_ns = 10 * kOneSecond_ns;  // clocks that are farther apart were not set by each other

/// The packets of one sensor come from one address to one port.
struct Stream {
  std::uint32_t source = 0;
  std::uint16_t port = 0;
  friend bool operator==(const Stream&, const Stream&) = default;
};

struct SweepStart {
  std::uint64_t offset = 0;      ///< of its first packet in the file
  std::size_t block = 0;         ///< of this packet
  std::uint32_t turn = 0;        ///< PacketHead::turn
  std::int64_t clock_ns = 0;     ///< the sensor's, of the packet
  std::int64_t captured_ns = 0;  ///< the computer's, of the packet
};

/// A sensor's clock that begins anew after each period, without its jumps: a packet is as much later than the one
/// before as it was captured later, within half a period.
class SensorClock {
 public:
  explicit SensorClock(std::int64_t period_ns) : period_ns_(period_ns) {}

  void set(std::int64_t clock_ns, std::int64_t captured_ns) { ahead_ns_ = clock_ns - captured_ns; }

  [[nodiscard]] std::int64_t unrolled(std::int64_t clock_ns, std::int64_t captured_ns) {
    std::int64_t time_ns = clock_ns;
    if (period_ns_ > 0) {
      const std::int64_t expected = captured_ns + (std::abs(ahead_ns_) <= period_ns_ ? ahead_ns_ : 0);
      const double periods = static_cast<double>(expected - clock_ns) / static_cast<double>(period_ns_);
      time_ns += std::llround(periods) * period_ns_;
    }
    set(time_ns, captured_ns);
    return time_ns;
  }

 private:
  std::int64_t period_ns_;
  std::int64_t ahead_ns_ = 0;  ///< of the capture's clock, at the packet before
};

/// The UDP packets of a capture that are not understood, for a message.
class SeenPackets {
 public:
  void add(const UdpDatagram& datagram) {
    constexpr std::size_t kMostKinds = 100;
    const std::pair<std::uint16_t, std::size_t> kind(datagram.port, datagram.payload.size());
    if (counts_.size() < kMostKinds || counts_.contains(kind)) ++counts_[kind];
  }

  /// The most frequent first.
  [[nodiscard]] std::string text() const {
    if (counts_.empty()) return "no UDP packet over IPv4";
    using Count = std::pair<std::pair<std::uint16_t, std::size_t>, std::uint64_t>;
    std::vector<Count> counts(counts_.begin(), counts_.end());
    std::stable_sort(counts.begin(), counts.end(), [](const Count& a, const Count& b) { return a.second > b.second; });
    constexpr std::size_t kMostShown = 6;
    std::string text = "UDP packets";
    for (std::size_t i = 0; i < std::min(counts.size(), kMostShown); ++i) {
      text += fmt::format("{} {} of {} bytes to port {}", i == 0 ? "" : ",", counts[i].second, counts[i].first.second,
                          counts[i].first.first);
    }
    return counts.size() > kMostShown ? text + " and others" : text;
  }

 private:
  std::map<std::pair<std::uint16_t, std::size_t>, std::uint64_t> counts_;
};

/// A .json beside a capture.
struct MetadataFile {
  std::string name;
  Result<OusterMetadata> metadata;
};

/// How well a .json's name fits the capture's: NAME.json, NAME_*.json, any.
int misfit(const std::string& json, const std::string& stem) {
  if (json == stem + ".json") return 0;
  return json.starts_with(stem) ? 1 : 2;
}

/// The metadata files of the capture's folder, those with its name first.
std::vector<MetadataFile> find_metadata(const fs::path& capture, const Limits& limits) {
  std::error_code code;
  const auto folder = list_folder(fs::absolute(capture, code).parent_path(), limits);
  if (!folder) return {};
  std::vector<std::string> names;
  for (const std::string& name : folder->files) {
    if (name.ends_with(".json")) names.push_back(name);
  }
  const std::string stem = capture.stem().string();
  std::stable_sort(names.begin(), names.end(),
                   [&](const auto& a, const auto& b) { return misfit(a, stem) < misfit(b, stem); });
  constexpr std::size_t kMostFiles = 100;
  constexpr std::uintmax_t kMostBytes = 1U << 20;  // metadata has 10 KB
  std::vector<MetadataFile> files;
  for (std::size_t i = 0; i < std::min(names.size(), kMostFiles); ++i) {
    const auto text = read_text_file(folder->path / names[i], std::min(kMostBytes, limits.max_text_bytes));
    if (!text) continue;
    auto metadata = parse_ouster_metadata(*text);
    if (metadata || misfit(names[i], stem) < 2) files.push_back({names[i], std::move(metadata)});
  }
  return files;
}

/// The place of the trajectory; nothing: there is none.
std::optional<fs::path> find_trajectory(const fs::path& capture) {
  std::error_code code;
  const fs::path folder = fs::absolute(capture, code).parent_path();
  const std::string stem = capture.stem().string();
  for (const std::string& name :
       {stem + ".tum", stem + ".txt", std::string("poses.txt"), std::string("trajectory.txt")}) {
    if (fs::exists(folder / name, code)) return folder / name;
  }
  return std::nullopt;
}

double seconds(std::int64_t time_ns) {
  return static_cast<double>(time_ns) * 1e-9;
}

class PcapSweeps final : public SweepSource {
 public:
  PcapSweeps(const fs::path& path, UdpDatagrams datagrams, const Limits& limits)
      : path_(path), datagrams_(std::move(datagrams)), limits_(limits) {}

  [[nodiscard]] Result<void> open() {
    info_.folder = path_;
    info_.world_up = UpAxis::kZ;
    const std::string stem = path_.stem().string();
    info_.expected_poses = fmt::format(
        "{0}.tum, {0}.txt, poses.txt or trajectory.txt beside the capture: lines 'seconds x y z qx qy qz qw' with the "
        "sensor's pose in the world, in the time of the packets (Unix time)",
        stem);
    if (auto found = find_sensor(); !found) return found;
    if (auto indexed = find_sweeps(); !indexed) return indexed;
    if (auto read = read_poses(); !read) return read;
    conclude_info();
    return {};
  }

  [[nodiscard]] const SweepInfo& info() const override { return info_; }

  [[nodiscard]] std::variant<Sweep, FrameDropped> read(std::size_t index) override {
    const SweepStart& start = starts_.at(index);
    const auto dropped = [&](DropReason reason, std::string message) {
      message = fmt::format("sweep {} at {:.3f} s: {}", index, seconds(time_ns(start)), message);
      return FrameDropped{index, reason, Error{ErrorCode::kInput, std::move(message), path_.string()}};
    };
    const auto pose = pose_at(poses_, time_ns(start), kPoseGap_ns);
    if (!pose) return dropped(DropReason::kNoPose, "no pose; expected " + info_.expected_poses);
    if (!*pose) return dropped(DropReason::kBadPose, pose->error().text());
    Sweep sweep{.sequence = index, .timestamp_ns = time_ns(start), .T_world_sensor = **pose};
    add_points(index, sweep);
    if (sweep.points_m.empty()) return dropped(DropReason::kNoDepth, "no return");
    if (!undo_motion([this](std::int64_t time) { return valid_pose_at(time); }, sweep)) {
      return dropped(DropReason::kNoPose, "the poses do not reach over the whole sweep");
    }
    return sweep;
  }

 private:
  /// The first packets that are understood tell the sensor.
  [[nodiscard]] Result<void> find_sensor() {
    const auto files = find_metadata(path_, limits_);
    SeenPackets seen;
    std::optional<Error> refused;
    while (const auto datagram = datagrams_.next()) {
      seen.add(*datagram);
      if (auto velodyne = velodyne_of(datagram->payload)) {
        if (*velodyne) return choose(*datagram, std::move(**velodyne));
        if (!refused) refused = velodyne->error();
      }
      for (const MetadataFile& file : files) {
        if (!file.metadata || file.metadata->packet_bytes() != datagram->payload.size()) continue;
        return choose(*datagram, ouster_packets(*file.metadata));
      }
    }
    if (refused) return located(*refused, path_);
    std::string message = fmt::format(
        "no packets of a LiDAR that is read; there are {}. Expected 1206 bytes of a Velodyne, or an Ouster's with the "
        "sensor's metadata beside the capture: {}.json",
        seen.text(), path_.stem().string());
    for (const MetadataFile& file : files) {
      message += file.metadata ? fmt::format(". {}: packets have {} bytes", file.name, file.metadata->packet_bytes())
                               : fmt::format(". {}: {}", file.name, file.metadata.error().message);
    }
    if (datagrams_.cut_short() > 0)
      message += fmt::format(". {} packets were captured in part only", datagrams_.cut_short());
    if (!datagrams_.records().damage().empty()) message += ". Also, " + datagrams_.records().damage();
    return Error{ErrorCode::kInput, std::move(message), path_.string()};
  }

  [[nodiscard]] Result<void> choose(const UdpDatagram& datagram, std::unique_ptr<LidarPackets> packets) {
    packets_ = std::move(packets);
    stream_ = {datagram.source, datagram.port};
    info_.format = packets_->name();
    datagrams_.seek(datagram.offset);
    return {};
  }

  /// A packet of the sensor.
  [[nodiscard]] bool is_ours(const UdpDatagram& datagram) const {
    return Stream{datagram.source, datagram.port} == stream_ && packets_->fits(datagram.payload);
  }

  [[nodiscard]] Result<void> find_sweeps() {
    SensorClock clock(packets_->clock_period_ns());
    std::int64_t before_ns = 0;
    std::size_t in_sweep = 0;
    bool has_gap = false;
    while (const auto datagram = datagrams_.next()) {
      if (!is_ours(*datagram)) {
        others_ += packets_->fits(datagram->payload) ? 1 : 0;
        continue;
      }
      const auto head = packets_->head(datagram->payload);
      if (!head) continue;
      const std::int64_t clock_ns = clock.unrolled(head->clock_ns, datagram->time_ns);
      least_delay_ns_ = std::min(least_delay_ns_, datagram->time_ns - clock_ns);
      const bool has_pause = !starts_.empty() && std::abs(clock_ns - starts_.back().clock_ns) > kPause_ns;
      if (starts_.empty() || head->turn_begins || has_pause || in_sweep >= kMostSweepPackets) {
        if (starts_.size() >= limits_.max_frames) {
          return Error{ErrorCode::kInput, fmt::format("more than {} sweeps", limits_.max_frames), path_.string()};
        }
        const std::size_t block = starts_.empty() ? 0 : head->turn_begins.value_or(0);
        starts_.push_back({datagram->offset, block, head->turn, clock_ns, datagram->time_ns});
        in_sweep = 0;
        has_gap = false;
      } else if (is_gap(clock_ns - before_ns) && !has_gap) {
        has_gap = true;
        ++with_gaps_;
      }
      ++in_sweep;
      before_ns = clock_ns;
    }
    if (starts_.empty()) {
      return Error{ErrorCode::kInput, "the LiDAR's packets hold no measurement", path_.string()};
    }
    return {};
  }

  /// More than a packet is missing between two.
  [[nodiscard]] bool is_gap(std::int64_t step_ns) const {
    return packets_->duration_ns() > 0 && step_ns > packets_->duration_ns() * 7 / 4;
  }

  [[nodiscard]] Result<void> read_poses() {
    const std::int64_t off_ns = least_delay_ns_;
    shift_ns_ = std::abs(off_ns) < kSameClock_ns ? 0 : off_ns;
    const auto place = find_trajectory(path_);
    if (place) {
      auto poses = read_tum_poses(*place, limits_);
      if (!poses) return poses.error();
      poses_ = *std::move(poses);
      choose_clock();
      explain_no_pose(*place);
    }
    if (shift_ns_ != 0) {
      info_.warnings.push_back(
          fmt::format("the LiDAR's clock is {:.3f} s {} the computer's: the sweeps have the computer's time",
                      std::abs(seconds(shift_ns_)), shift_ns_ > 0 ? "behind" : "ahead of"));
    }
    return {};
  }

  /// The trajectory may be in the time of the sensor or of the computer that captured.
  void choose_clock() {
    info_.sweeps_with_pose = count_poses();
    if (info_.sweeps_with_pose > 0) return;
    const std::int64_t usual_ns = shift_ns_;
    shift_ns_ = usual_ns == 0 ? least_delay_ns_ : 0;
    info_.sweeps_with_pose = count_poses();
    if (info_.sweeps_with_pose == 0) shift_ns_ = usual_ns;
  }

  [[nodiscard]] std::size_t count_poses() const {
    return static_cast<std::size_t>(std::count_if(starts_.begin(), starts_.end(), [this](const SweepStart& start) {
      return valid_pose_at(time_ns(start)).has_value();
    }));
  }

  void explain_no_pose(const fs::path& place) {
    if (info_.sweeps_with_pose > 0) return;
    info_.expected_poses +=
        poses_.empty()
            ? fmt::format(". {} has no pose", place.string())
            : fmt::format(
                  ". No sweep lies within {}: it is of {:.3f} to {:.3f} s, the sweeps are of {:.3f} to {:.3f} s",
                  place.string(), seconds(poses_.front().time_ns), seconds(poses_.back().time_ns),
                  seconds(time_ns(starts_.front())), seconds(time_ns(starts_.back())));
  }

  void conclude_info() {
    info_.sweeps = starts_.size();
    info_.duration_s = seconds(starts_.back().clock_ns - starts_.front().clock_ns);
    const auto warn = [&](std::string warning) { info_.warnings.push_back(std::move(warning)); };
    if (with_gaps_ > 0) {
      warn(fmt::format("packets are missing in {} of {} sweeps, which are read with gaps", with_gaps_, info_.sweeps));
    }
    if (others_ > 0) warn(fmt::format("{} packets of another LiDAR are not read", others_));
    if (datagrams_.cut_short() > 0) {
      warn(fmt::format("{} packets were captured in part only and are not read: capture whole packets (tcpdump -s 0)",
                       datagrams_.cut_short()));
    }
    if (datagrams_.incomplete() > 0) {
      warn(fmt::format("{} packets are not read because fragments of them are missing", datagrams_.incomplete()));
    }
    if (!datagrams_.records().damage().empty()) warn(datagrams_.records().damage());
  }

  [[nodiscard]] std::int64_t time_ns(const SweepStart& start) const { return start.clock_ns + shift_ns_; }

  [[nodiscard]] std::optional<Pose> valid_pose_at(std::int64_t time_ns) const {
    const auto pose = pose_at(poses_, time_ns, kPoseGap_ns);
    return pose && *pose ? std::optional(**pose) : std::nullopt;
  }

  void add_points(std::size_t index, Sweep& sweep) {
    const SweepStart& start = starts_[index];
    const SweepStart* next = index + 1 < starts_.size() ? &starts_[index + 1] : nullptr;
    SensorClock clock(packets_->clock_period_ns());
    clock.set(start.clock_ns, start.captured_ns);
    datagrams_.seek(start.offset);
    for (std::size_t packets = 0; packets <= kMostSweepPackets;) {
      const auto datagram = datagrams_.next();
      if (!datagram) return;
      const bool is_next = next != nullptr && datagram->offset >= next->offset;
      if (is_next && next->block == 0) return;
      if (!is_ours(*datagram)) continue;
      const auto head = packets_->head(datagram->payload);
      if (!head) continue;
      ++packets;
      const std::int64_t offset_ns = clock.unrolled(head->clock_ns, datagram->time_ns) - start.clock_ns;
      const bool fits = head->turn == start.turn && std::abs(offset_ns) <= kPause_ns;
      const PacketBlocks blocks{datagram->offset == start.offset ? start.block : 0,
                                is_next ? next->block : packets_->blocks()};
      if (fits) packets_->add_points(datagram->payload, blocks, offset_ns, sweep);
      if (is_next) return;
    }
  }

  fs::path path_;
  UdpDatagrams datagrams_;
  Limits limits_;
  SweepInfo info_;
  std::unique_ptr<LidarPackets> packets_;
  Stream stream_;
  std::vector<SweepStart> starts_;
  std::vector<TimedPose> poses_;  ///< of the sensor in the world
  /// What the computer's clock is ahead of the sensor's at least: the delay of a packet is never negative.
  std::int64_t least_delay_ns_ = std::numeric_limits<std::int64_t>::max();
  std::int64_t shift_ns_ = 0;  ///< from the sensor's clock to that of the sweeps
  std::size_t with_gaps_ = 0, others_ = 0;
};

}  // namespace

Result<std::unique_ptr<SweepSource>> open_pcap_sweeps(const fs::path& path, const Limits& limits) {
  auto file = open_random_access(path);
  if (!file) return file.error();
  return open_pcap_sweeps(*std::move(file), path, limits);
}

Result<std::unique_ptr<SweepSource>> open_pcap_sweeps(std::unique_ptr<RandomAccess> file, const fs::path& path,
                                                      const Limits& limits) {
  auto records = PcapRecords::open(std::move(file));
  if (!records) return located(records.error(), path);
  auto sweeps = std::make_unique<PcapSweeps>(path, UdpDatagrams(*std::move(records)), limits);
  if (auto opened = sweeps->open(); !opened) return opened.error();
  return std::unique_ptr<SweepSource>(std::move(sweeps));
}

}  // namespace scanknit
