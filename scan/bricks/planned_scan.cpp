#include "scan/bricks/planned_scan.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>

#include "core/files/crc32.h"
#include "core/files/little_endian.h"
#include "scan/bricks/plan_bytes.h"
#include "scan/bricks/tracked_bytes.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using BitSettings = std::array<double, 8>;

BitSettings settings_of(const FusionConfig& config) {
  return {config.voxel_size_m,  config.truncation_voxels,           config.truncation_sigmas,
          config.noise.floor_m, config.noise.growth_per_m,          config.noise.from_m,
          config.max_weight,    config.carve_free_space ? 1.0 : 0.0};
}

void append_pose(std::string& bytes, const Pose& pose) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) append_little_endian(bytes, pose(row, column));
  }
}

void append_steady(std::string& bytes, const SteadyMotion& motion) {
  for (const Eigen::Vector3d& part : {motion.turn_rad, motion.shift_m}) {
    for (int axis = 0; axis < 3; ++axis) append_little_endian(bytes, part[axis]);
  }
}

/// A byte that is 1 if the motion follows.
void append_motion(std::string& bytes, const FrameMotion& motion) {
  append_little_endian(bytes, static_cast<std::uint8_t>(motion.is_still() ? 0 : 1));
  if (motion.is_still()) return;
  append_steady(bytes, motion.rows);
  append_steady(bytes, motion.to_colour);
}

void append_counts(std::string& bytes, const FrameCounts& counts) {
  for (const std::size_t count : {counts.read, counts.fused, counts.dropped, counts.lost}) append_count(bytes, count);
  append_count(bytes, counts.dropped_by_reason.size());
  for (const auto& [reason, count] : counts.dropped_by_reason) {
    append_text(bytes, reason);
    append_count(bytes, count);
  }
  append_count(bytes, counts.drop_messages.size());
  for (const std::string& message : counts.drop_messages) append_text(bytes, message);
}

void append_brick_part(std::string& bytes, const BrickPart& part) {
  std::vector<Coord> regions(part.regions.begin(), part.regions.end());
  std::sort(regions.begin(), regions.end());
  append_count(bytes, regions.size());
  for (const Coord& region : regions) {
    for (int axis = 0; axis < 3; ++axis) append_little_endian(bytes, static_cast<std::int32_t>(region[axis]));
  }
  append_count(bytes, part.most_bytes);
  append_count(bytes, part.frames.size());
  for (const FrameRun& run : part.frames) {
    append_little_endian(bytes, run.first);
    append_little_endian(bytes, run.last);
  }
}

Pose take_pose(PlanReader& plan) {
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) pose(row, column) = plan.number<double>();
  }
  return pose;
}

SteadyMotion take_steady(PlanReader& plan) {
  SteadyMotion motion;
  for (Eigen::Vector3d* part : {&motion.turn_rad, &motion.shift_m}) {
    for (int axis = 0; axis < 3; ++axis) (*part)[axis] = plan.number<double>();
  }
  return motion;
}

FrameMotion take_motion(PlanReader& plan) {
  if (plan.number<std::uint8_t>() == 0) return {};
  const SteadyMotion rows = take_steady(plan);
  return {rows, take_steady(plan)};
}

FrameCounts take_counts(PlanReader& plan) {
  FrameCounts counts;
  for (std::size_t* count : {&counts.read, &counts.fused, &counts.dropped, &counts.lost}) *count = plan.size();
  for (std::size_t left = plan.count(16); left > 0; --left) {
    const std::string reason = plan.text();
    counts.dropped_by_reason[reason] = plan.size();
  }
  for (std::size_t left = plan.count(8); left > 0; --left) counts.drop_messages.push_back(plan.text());
  return counts;
}

BrickPart take_part(PlanReader& plan, std::size_t most_frames) {
  BrickPart part;
  for (std::size_t left = plan.count(12); left > 0; --left) {
    std::array<std::int32_t, 3> at;
    for (std::int32_t& value : at) value = plan.number<std::int32_t>();
    part.regions.insert(Coord(at[0], at[1], at[2]));
  }
  part.most_bytes = plan.size();
  std::uint32_t before = 0;
  for (std::size_t left = plan.count(8); left > 0; --left) {
    const auto first = plan.number<std::uint32_t>();
    const auto last = plan.number<std::uint32_t>();
    plan.require(first > before && last >= first && last <= most_frames);
    part.frames.push_back({first, last});
    before = last;
  }
  plan.require(!part.frames.empty());
  return part;
}

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

Trajectory PlannedScan::recorded_order() const {
  Trajectory ordered = trajectory;
  std::sort(ordered.begin(), ordered.end(),
            [](const PosedFrame& a, const PosedFrame& b) { return a.sequence < b.sequence; });
  return ordered;
}

std::uint64_t plan_id(std::string_view bytes) {
  return std::uint64_t{bytes.size()} << 32 | crc32(std::as_bytes(std::span(bytes)));
}

std::uint32_t checksum_of(const Frame& frame, PoseOrigin poses) {
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
  if (poses == PoseOrigin::kRecording && frame.T_world_camera) checksum.add(*frame.T_world_camera);
  return checksum.value();
}

std::string bytes_of(const PlannedScan& planned) {
  std::string bytes;
  for (const double setting : settings_of(planned.fusion)) append_little_endian(bytes, setting);
  append_little_endian(bytes, static_cast<std::uint8_t>(planned.world_up));
  append_little_endian(bytes, static_cast<std::uint8_t>(planned.poses));
  append_tracked(bytes, planned.tracked);
  append_counts(bytes, planned.counts);
  append_count(bytes, planned.trajectory.size());
  for (std::size_t i = 0; i < planned.trajectory.size(); ++i) {
    const PosedFrame& posed = planned.trajectory[i];
    append_little_endian(bytes, posed.sequence);
    append_little_endian(bytes, posed.stamp);
    append_pose(bytes, posed.T_world_camera);
    append_motion(bytes, posed.motion);
    append_little_endian(bytes, planned.checksums[i]);
  }
  append_count(bytes, planned.samples.size());
  for (const std::uint32_t number : planned.samples) append_little_endian(bytes, number);
  append_count(bytes, planned.parts.size());
  for (const BrickPart& part : planned.parts) append_brick_part(bytes, part);
  return bytes;
}

std::optional<PlannedScan> parse_planned(std::string_view bytes, const FusionConfig& fusion) {
  constexpr std::size_t kFrameBytes = 8 + 8 + 12 * 8 + 1 + 4;
  PlanReader plan{ByteReader(std::as_bytes(std::span(bytes)))};
  PlannedScan planned;
  planned.fusion = fusion;
  BitSettings settings;
  for (double& setting : settings) setting = plan.number<double>();
  const auto up = plan.number<std::uint8_t>();
  planned.world_up = static_cast<UpAxis>(up);
  const auto poses = plan.number<std::uint8_t>();
  planned.poses = static_cast<PoseOrigin>(poses);
  planned.tracked = take_tracked(plan);
  planned.counts = take_counts(plan);
  for (std::size_t left = plan.count(kFrameBytes); left > 0; --left) {
    PosedFrame posed;
    posed.sequence = plan.number<std::uint64_t>();
    posed.stamp = plan.number<double>();
    posed.T_world_camera = take_pose(plan);
    posed.motion = take_motion(plan);
    planned.trajectory.push_back(posed);
    planned.checksums.push_back(plan.number<std::uint32_t>());
  }
  for (std::size_t left = plan.count(4); left > 0; --left) {
    planned.samples.push_back(plan.number<std::uint32_t>());
    plan.require(planned.samples.back() >= 1 && planned.samples.back() <= planned.trajectory.size());
  }
  for (std::size_t left = plan.count(24); left > 0; --left) {
    planned.parts.push_back(take_part(plan, planned.trajectory.size()));
  }
  plan.require(plan.is_at_end() && up <= static_cast<std::uint8_t>(UpAxis::kMinusZ) &&
               poses <= static_cast<std::uint8_t>(PoseOrigin::kPlan));
  if (!plan.is_whole() || settings != settings_of(fusion)) return std::nullopt;
  return planned;
}

}  // namespace scanknit
