#include "scan/bricks/scan_in_bricks.h"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "core/files/part_folder.h"
#include "fusion/bricks/brick_volume.h"
#include "fusion/bricks/paged_volume.h"
#include "scan/bricks/fuse_parts.h"
#include "scan/bricks/join_parts.h"
#include "scan/bricks/plan_parts.h"
#include "scan/bricks/planned_frames.h"
#include "scan/checks/memory_share.h"
#include "scan/frames/frame_intake.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// A file whose folder has room for what the scan writes.
fs::path largest_file(const ScanFiles& files) {
  const std::vector<fs::path> paths = all_paths(files);
  return paths.empty() ? fs::temp_directory_path() / "scan" : paths.front();
}

/// Fuses all parts, or those before a stop was requested; as many at once as the memory allows.
Result<BrickVolume> fuse_all(const ScanJob& job, const PlannedScan& planned, const fs::path& folder,
                             ScanSession& session) {
  BrickVolume bricks(job.config.fusion);
  const std::uint64_t id = plan_id(bytes_of(planned));
  const auto path_of = [&](std::size_t number) { return folder / fmt::format("{}.brick", number); };
  const std::size_t count = planned.parts.size();
  std::vector<std::size_t> left(count);
  std::iota(left.begin(), left.end(), std::size_t{0});
  while (!left.empty()) {
    const PartGroup group = first_group(planned, left, count);
    const auto is_whole = fuse_parts(job, planned, group, id, path_of, session);
    if (!is_whole) return is_whole.error();
    if (!*is_whole) break;
    for (const std::size_t number : group) {
      if (auto added = bricks.add(path_of(number), id); !added) return added.error();
    }
    left.erase(left.begin(), left.begin() + static_cast<std::ptrdiff_t>(group.size()));
    session.progress("fusing bricks", count - left.size(), count);
  }
  if (left.size() == count) return Error{ErrorCode::kInput, "interrupted before the first brick was fused"};
  if (!left.empty()) {
    session.warn(WarningCode::kStoppedEarly, fmt::format("interrupted: the mesh holds {} of the {} parts of the volume",
                                                         count - left.size(), count));
  }
  return bricks;
}

Result<void> scan(const ScanJob& job, const PassInput& input, ScanSession& session, ScanResult& result) {
  DepthSamples samples;
  const auto planned =
      plan_parts(job, input, PoseOrigin::kRecording, session, result.frames, needs_samples(job) ? &samples : nullptr);
  if (!planned) return planned.error();
  result.trajectory = planned->trajectory;
  if (auto written = write_trajectory(job, session, result); !written) return written;
  const auto folder = PartFolder::create(largest_file(job.files));
  if (!folder) return folder.error();
  const auto bricks = fuse_all(job, *planned, folder->path(), session);
  if (!bricks) return bricks.error();
  return join_parts(job, planned->world_up, *bricks, samples, input.archive, session, result);
}

/// Nothing: it cannot be done within the budget.
Result<std::optional<BrickVolume>> fuse_in_pages(const ScanJob& job, const PassInput& input, const fs::path& folder,
                                                 ScanSession& session, DepthSamples* samples, ScanResult& result) {
  auto volume = PagedVolume::create(volume_config(job.config.fusion), folder);
  if (!volume) return volume.error();
  FrameIntake intake(input.source, job.config.acquire, session, {input.stop, input.counted});
  while (!intake.is_over()) {
    auto frame = intake.next();
    if (!frame) continue;
    if (auto prepared = prepare(*frame, {}, job.config, session); !prepared) return prepared.error();
    const Pose T_world_camera = *frame->T_world_camera;
    const auto stats = session.timed("integrate", [&] { return volume->integrate(*frame, T_world_camera); });
    if (!stats && stats.error().code == ErrorCode::kBudget) {
      session.info(stats.error().message + ": the volume is fused in parts instead, which takes longer");
      return std::optional<BrickVolume>();
    }
    const bool is_refused = !stats && stats.error().code == ErrorCode::kInput;
    if (!stats && !is_refused) return stats.error();
    if (is_refused) {
      intake.count(*frame, {{}, stats.error()});
    } else {
      intake.count(*frame, {T_world_camera});
      result.trajectory.push_back({frame->sequence, stamp_of(*frame), T_world_camera});
      if (samples != nullptr) samples->add(*frame);
    }
  }
  result.frames = intake.counts();
  if (auto concluded = intake.conclude(); !concluded) return concluded.error();
  auto whole = session.timed("write_bricks", [&] { return volume->finish(); });
  if (!whole) return whole.error();
  return std::optional(*std::move(whole));
}

/// False: it cannot be done within the budget.
Result<bool> page(const ScanJob& job, const PassInput& input, ScanSession& session, ScanResult& result) {
  const auto folder = PartFolder::create(largest_file(job.files));
  if (!folder) return folder.error();
  DepthSamples samples;
  const auto fused =
      fuse_in_pages(job, input, folder->path(), session, needs_samples(job) ? &samples : nullptr, result);
  if (!fused) return fused.error();
  if (!*fused) return false;
  if (auto written = write_trajectory(job, session, result); !written) return written.error();
  const auto joined = join_parts(job, input.source.info().world_up, **fused, samples, input.archive, session, result);
  return joined ? Result<bool>(true) : joined.error();
}

}  // namespace

std::optional<ScanResult> scan_in_pages(const ScanJob& job, const PassInput& input, ScanSession& session) {
  ScanResult result;
  const auto is_done = page(job, input, session, result);
  if (is_done && !*is_done) return std::nullopt;
  if (!is_done) result.outcome = is_done.error();
  return result;
}

ScanResult scan_in_parts(const ScanJob& job, const PassInput& input, ScanSession& session) {
  ScanResult result;
  result.outcome = scan(job, input, session, result);
  return result;
}

}  // namespace scanknit
