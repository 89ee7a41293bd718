#include "scan/bricks/planned_scan.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <span>
#include <utility>

#include "core/files/crc32.h"
#include "core/files/little_endian.h"
#include "core/files/sha256.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using BitSettings = std::array<double, 8>;

BitSettings settings_of(const FusionConfig& config) {
  return {config.voxel_size_m,  config.truncation_voxels,           config.truncation_sigmas,
          config.noise.floor_m, config.noise.growth_per_m,          config.noise.from_m,
          config.max_weight,    config.carve_free_space ? 1.0 : 0.0};
}

void append_count(std::string& bytes, std::size_t count) {
  append_little_endian(bytes, static_cast<std::uint64_t>(count));
}

void append_plan_text(std::string& bytes, const std::string& text) {
  append_count(bytes, text.size());
  bytes += text;
}

void append_pose(std::string& bytes, const Pose& pose) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) append_little_endian(bytes, pose(row, column));
  }
}

void append_counts(std::string& bytes, const FrameCounts& counts) {
  for (const std::size_t count : {counts.read, counts.fused, counts.dropped, counts.lost}) append_count(bytes, count);
  append_count(bytes, counts.dropped_by_reason.size());
  for (const auto& [reason, count] : counts.dropped_by_reason) {
    append_plan_text(bytes, reason);
    append_count(bytes, count);
  }
  append_count(bytes, counts.drop_messages.size());
  for (const std::string& message : counts.drop_messages) append_plan_text(bytes, message);
}

void append_brick_part(std::string& bytes, const BrickPart& part) {
  std::vector<Coord> regions(part.regions.begin(), part.regions.end());
  std::sort(regions.begin(), regions.end());
  append_count(bytes, regions.size());
  for (const Coord& region : regions) {
    for (int axis = 0; axis < 3; ++axis) append_little_endian(bytes, static_cast<std::int32_t>(region[axis]));
  }
  append_count(bytes, part.frames.size());
  for (const FrameRun& run : part.frames) {
    append_little_endian(bytes, run.first);
    append_little_endian(bytes, run.last);
  }
}

/// Reads what the functions above wrote. After a read that does not fit, everything is 0 and is_whole() false.
class PlanReader {
 public:
  explicit PlanReader(ByteReader& reader) : reader_(reader) {}
  [[nodiscard]] bool is_whole() const { return is_whole_; }

  template <typename T>
  [[nodiscard]] T number() {
    const auto value = reader_.little_endian<T>();
    is_whole_ = is_whole_ && value;
    return is_whole_ ? *value : T{};
  }

  /// A count of things that take at least `least_bytes` each.
  [[nodiscard]] std::size_t count(std::size_t least_bytes) {
    const auto count = number<std::uint64_t>();
    is_whole_ = is_whole_ && count <= reader_.remaining() / least_bytes;
    return is_whole_ ? static_cast<std::size_t>(count) : 0;
  }

  [[nodiscard]] std::string text() {
    const auto bytes = reader_.take(count(1));
    std::string text;
    if (bytes)
      std::transform(bytes->begin(), bytes->end(), std::back_inserter(text),
                     [](std::byte b) { return static_cast<char>(b); });
    return text;
  }

  [[nodiscard]] Pose pose() {
    Pose pose = Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) pose(row, column) = number<double>();
    }
    return pose;
  }

  [[nodiscard]] FrameCounts counts() {
    FrameCounts counts;
    for (std::size_t* count : {&counts.read, &counts.fused, &counts.dropped, &counts.lost}) {
      *count = static_cast<std::size_t>(number<std::uint64_t>());
    }
    for (std::size_t left = count(16); left > 0; --left) {
      const std::string reason = text();
      counts.dropped_by_reason[reason] = static_cast<std::size_t>(number<std::uint64_t>());
    }
    for (std::size_t left = count(8); left > 0; --left) counts.drop_messages.push_back(text());
    return counts;
  }

  [[nodiscard]] BrickPart part(std::size_t most_frames) {
    BrickPart part;
    for (std::size_t left = count(12); left > 0; --left) {
      std::array<std::int32_t, 3> at;
      for (std::int32_t& value : at) value = number<std::int32_t>();
      part.regions.insert(Coord(at[0], at[1], at[2]));
    }
    std::uint32_t before = 0;
    for (std::size_t left = count(8); left > 0; --left) {
      const auto first = number<std::uint32_t>();
      const auto last = number<std::uint32_t>();
      is_whole_ = is_whole_ && first > before && last >= first && last <= most_frames;
      part.frames.push_back({first, last});
      before = last;
    }
    is_whole_ = is_whole_ && !part.frames.empty();
    return part;
  }

 private:
  ByteReader& reader_;
  bool is_whole_ = true;
};

class FrameChecksum {
 public:
  [[nodiscard]] std::uint32_t value() const { return crc_; }

  template <typename T>
  void add(const Image<T>& image) {
    numbers(static_cast<std::int32_t>(image.width()), static_cast<std::int32_t>(image.height()));
    crc_ = crc32(std::as_bytes(image.pixels()), crc_);
  }

  void add(const CameraIntrinsics& camera) {
    numbers(static_cast<std::int32_t>(camera.width), static_cast<std::int32_t>(camera.height), camera.fx, camera.fy,
            camera.cx, camera.cy);
  }

  void add(const Pose& pose) {
    std::string bytes;
    append_pose(bytes, pose);
    add_bytes(bytes);
  }

 private:
  template <typename... Numbers>
  void numbers(Numbers... values) {
    std::string bytes;
    (append_little_endian(bytes, values), ...);
    add_bytes(bytes);
  }
  void add_bytes(const std::string& bytes) { crc_ = crc32(std::as_bytes(std::span(bytes)), crc_); }

  std::uint32_t crc_ = 0;
};

}  // namespace

std::optional<std::uint32_t> PlannedScan::number_of(std::uint64_t sequence) const {
  const auto found = std::lower_bound(trajectory.begin(), trajectory.end(), sequence,
                                      [](const PosedFrame& posed, std::uint64_t s) { return posed.sequence < s; });
  if (found == trajectory.end() || found->sequence != sequence) return std::nullopt;
  return static_cast<std::uint32_t>(found - trajectory.begin()) + 1;
}

std::uint64_t PlannedScan::id() const {
  const Sha256 hash = sha256(bytes_of(*this));
  std::uint64_t id = 0;
  for (std::size_t i = 0; i < sizeof(id); ++i) id = id << 8 | hash[i];
  return id;
}

std::uint32_t checksum_of(const Frame& frame) {
  FrameChecksum checksum;
  checksum.add(frame.depth_m);
  checksum.add(frame.intrinsics);
  if (frame.colour) {
    checksum.add(frame.colour->image);
    checksum.add(frame.colour->intrinsics);
    checksum.add(frame.colour->T_colour_depth);
  }
  checksum.add(frame.weights);
  checksum.add(frame.outside_m);
  if (frame.T_world_camera) checksum.add(*frame.T_world_camera);
  return checksum.value();
}

std::string bytes_of(const PlannedScan& planned) {
  std::string bytes;
  for (const double setting : settings_of(planned.fusion)) append_little_endian(bytes, setting);
  append_little_endian(bytes, static_cast<std::uint8_t>(planned.world_up));
  append_counts(bytes, planned.counts);
  append_count(bytes, planned.trajectory.size());
  for (std::size_t i = 0; i < planned.trajectory.size(); ++i) {
    const PosedFrame& posed = planned.trajectory[i];
    append_little_endian(bytes, posed.sequence);
    append_little_endian(bytes, posed.stamp);
    append_pose(bytes, posed.T_world_camera);
    append_little_endian(bytes, planned.checksums[i]);
  }
  append_count(bytes, planned.parts.size());
  for (const BrickPart& part : planned.parts) append_brick_part(bytes, part);
  return bytes;
}

std::optional<PlannedScan> parse_planned(ByteReader& reader, const FusionConfig& fusion) {
  constexpr std::size_t kFrameBytes = 8 + 8 + 12 * 8 + 4;
  PlanReader plan(reader);
  PlannedScan planned;
  planned.fusion = fusion;
  BitSettings settings;
  for (double& setting : settings) setting = plan.number<double>();
  const auto up = plan.number<std::uint8_t>();
  planned.world_up = static_cast<UpAxis>(up);
  planned.counts = plan.counts();
  for (std::size_t left = plan.count(kFrameBytes); left > 0; --left) {
    PosedFrame posed;
    posed.sequence = plan.number<std::uint64_t>();
    posed.stamp = plan.number<double>();
    posed.T_world_camera = plan.pose();
    planned.trajectory.push_back(posed);
    planned.checksums.push_back(plan.number<std::uint32_t>());
  }
  for (std::size_t left = plan.count(16); left > 0; --left) {
    planned.parts.push_back(plan.part(planned.trajectory.size()));
  }
  const bool is_sound = plan.is_whole() && reader.remaining() == 0 && up <= static_cast<std::uint8_t>(UpAxis::kMinusZ);
  if (!is_sound || settings != settings_of(fusion)) return std::nullopt;
  return planned;
}

}  // namespace scanknit
