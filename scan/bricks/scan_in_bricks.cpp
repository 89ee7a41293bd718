#include "scan/bricks/scan_in_bricks.h"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "fusion/bricks/brick_volume.h"
#include "scan/bricks/fuse_parts.h"
#include "scan/bricks/join_parts.h"
#include "scan/bricks/part_folder.h"
#include "scan/bricks/plan_parts.h"

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
  return join_parts(job, *planned, *bricks, samples, input.archive, session, result);
}

}  // namespace

ScanResult scan_in_bricks(const ScanJob& job, const PassInput& input, ScanSession& session) {
  ScanResult result;
  result.outcome = scan(job, input, session, result);
  return result;
}

}  // namespace scanknit
