#include "scan/bricks/fuse_part.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "fusion/bricks/brick_file.h"
#include "fusion/integrate/integrate_part.h"
#include "scan/bricks/plan_parts.h"
#include "scan/frames/recorded_frames.h"

namespace scanknit {
namespace {

SequenceRanges sequences_of(const std::vector<FrameRun>& runs, const Trajectory& trajectory) {
  SequenceRanges sequences;
  for (const FrameRun& run : runs) {
    sequences.add(trajectory[run.first - 1].sequence);
    sequences.add(trajectory[run.last - 1].sequence);
    sequences.cut();
  }
  return sequences;
}

bool has_frame(const std::vector<FrameRun>& runs, std::uint32_t number) {
  const auto after =
      std::partition_point(runs.begin(), runs.end(), [&](const FrameRun& run) { return run.last < number; });
  return after != runs.end() && after->first <= number;
}

Error has_changed(const ScanJob& job) {
  return {ErrorCode::kInput, "has changed since it was planned: give back what it was, or plan and scan it again",
          job.input.string()};
}

/// Calls `visit` with the frames of `runs`, filtered, and their numbers. False when a stop was requested before.
Result<bool> for_each_planned(const ScanJob& job, const PlannedScan& planned, const std::vector<FrameRun>& runs,
                              ScanSession& session, const std::function<Result<void>(Frame&, std::uint32_t)>& visit) {
  const SequenceRanges only = sequences_of(runs, planned.trajectory);
  const auto source = open_frames(job, &only);
  if (!source) return source.error();
  std::size_t left = count_frames(runs);
  const auto read = for_each_frame(**source, session.stop(), [&](Frame& frame) -> Result<Reading> {
    const auto number = planned.number_of(frame.sequence);
    if (!number || !has_frame(runs, *number)) return Reading::kContinue;
    if (checksum_of(frame) != planned.checksums[*number - 1]) return has_changed(job);
    if (auto filtered = filter(frame, job.config, session); !filtered) return filtered.error();
    if (auto visited = visit(frame, *number); !visited) return visited.error();
    return --left > 0 ? Reading::kContinue : Reading::kStop;
  });
  if (!read) return read.error();
  if (left == 0) return true;
  if (session.is_stopped()) return false;
  return has_changed(job);
}

}  // namespace

Result<bool> fuse_part(const ScanJob& job, const PlannedScan& planned, std::size_t number, std::uint64_t id,
                       const std::filesystem::path& path, ScanSession& session) {
  const BrickPart& part = planned.parts[number];
  auto volume = TsdfVolume::create(job.config.fusion);
  if (!volume) return volume.error();
  const auto fused = for_each_planned(job, planned, part.frames, session, [&](Frame& frame, std::uint32_t n) {
    const Pose& T_world_camera = planned.trajectory[n - 1].T_world_camera;
    const auto done =
        session.timed("integrate", [&] { return integrate_part(frame, T_world_camera, n, part.regions, *volume); });
    return done ? Result<void>() : done.error();
  });
  if (!fused || !*fused) return fused;
  if (volume->is_budget_reached) return Error{ErrorCode::kInternal, "a part of the volume is larger than planned"};
  const auto written = session.timed("write_bricks", [&] { return write_brick_file(*volume, id, path); });
  return written ? Result<bool>(true) : written.error();
}

Result<DepthSamples> samples_again(const ScanJob& job, const PlannedScan& planned, ScanSession& session) {
  std::vector<FrameRun> runs;
  const std::size_t spacing = DepthSamples::spacing(planned.trajectory.size());
  for (std::size_t i = 0; i < planned.trajectory.size(); i += spacing) {
    runs.push_back({static_cast<std::uint32_t>(i + 1), static_cast<std::uint32_t>(i + 1)});
  }
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
