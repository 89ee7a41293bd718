#include "scan/bricks/fuse_parts.h"

#include <utility>

#include "fusion/bricks/brick_file.h"
#include "fusion/integrate/integrate_part.h"
#include "scan/bricks/planned_frames.h"
#include "scan/checks/memory_share.h"

namespace scanknit {
namespace {

/// All frames and regions of a group.
BrickPart joined_part(const PlannedScan& planned, const PartGroup& group) {
  BrickPart joined;
  for (const std::size_t number : group) {
    const BrickPart& part = planned.parts[number];
    joined.regions.insert(part.regions.begin(), part.regions.end());
    joined.frames.insert(joined.frames.end(), part.frames.begin(), part.frames.end());
  }
  joined.frames = joined_runs(std::move(joined.frames));
  return joined;
}

}  // namespace

PartGroup first_group(const PlannedScan& planned, const std::vector<std::size_t>& numbers, std::size_t most) {
  const std::size_t max_bytes = volume_budget_mib(planned.fusion.memory_budget_mib) << 20;
  PartGroup group;
  std::size_t bytes = 0;
  for (const std::size_t number : numbers) {
    bytes += planned.parts[number].most_bytes;
    if (!group.empty() && (group.size() == most || bytes > max_bytes)) break;
    group.push_back(number);
  }
  return group;
}

Result<bool> fuse_parts(const ScanJob& job, const PlannedScan& planned, const PartGroup& group, std::uint64_t id,
                        const std::function<std::filesystem::path(std::size_t number)>& path_of, ScanSession& session) {
  const BrickPart part = joined_part(planned, group);
  auto volume = TsdfVolume::create(volume_config(job.config.fusion));
  if (!volume) return volume.error();
  const auto fused = for_each_planned(job, planned, part.frames, session, [&](Frame& frame, std::uint32_t n) {
    const Pose& T_world_camera = planned.trajectory[n - 1].T_world_camera;
    const auto done =
        session.timed("integrate", [&] { return integrate_part(frame, T_world_camera, n, part.regions, *volume); });
    return done ? Result<void>() : done.error();
  });
  if (!fused || !*fused) return fused;
  if (volume->is_budget_reached) return Error{ErrorCode::kInternal, "a part of the volume is larger than planned"};
  for (const std::size_t number : group) {
    const auto written = session.timed(
        "write_bricks", [&] { return write_brick_file(*volume, id, path_of(number), &planned.parts[number].regions); });
    if (!written) return written.error();
  }
  return true;
}

Result<DepthSamples> samples_again(const ScanJob& job, const PlannedScan& planned, ScanSession& session) {
  std::vector<FrameRun> runs;
  for (const std::uint32_t number : planned.samples) runs.push_back({number, number});
  DepthSamples samples;
  const auto read = for_each_planned(job, planned, runs, session, [&](Frame& frame, std::uint32_t) {
    samples.add(frame);
    return Result<void>();
  });
  if (!read) return read.error();
  if (!*read) return Error{ErrorCode::kInput, "interrupted before the mesh was made"};
  return samples;
}

}  // namespace scanknit
