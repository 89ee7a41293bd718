#include "scan/job/job_costs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "core/system/peak_memory.h"
#include "fusion/bricks/brick_volume.h"
#include "fusion/integrate/integrate_part.h"
#include "fusion/volume/volume_memory.h"
#include "scan/bricks/fuse_parts.h"
#include "scan/bricks/join_parts.h"
#include "scan/bricks/planned_frames.h"
#include "scan/checks/memory_share.h"
#include "scan/frames/recorded_frames.h"
#include "scan/job/job_estimate.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kBytesInMebibyte = 1024.0 * 1024.0;

double spent_since(double begin_s) {
  return std::max(0.0, processor_seconds() - begin_s);
}

Error interrupted() {
  return {ErrorCode::kInput, "interrupted before the job's costs were known"};
}

double bytes_in(const fs::path& place) {
  std::error_code code;
  if (fs::is_regular_file(place, code)) return static_cast<double>(fs::file_size(place, code));
  double bytes = 0;
  for (fs::recursive_directory_iterator entry(place, code), end; !code && entry != end; entry.increment(code)) {
    std::error_code unknown;
    const auto size = entry->is_regular_file(unknown) ? entry->file_size(unknown) : 0;
    if (!unknown) bytes += static_cast<double>(size);
  }
  return bytes;
}

/// Some frames, evenly spread, a few of them in succession.
std::vector<FrameRun> sampled_frames(std::size_t frames) {
  constexpr std::size_t kRuns = 4, kInSuccession = 10;
  if (frames <= kRuns * kInSuccession) return {{1, static_cast<std::uint32_t>(frames)}};
  std::vector<FrameRun> runs;
  for (std::size_t i = 0; i < kRuns; ++i) {
    const auto first = static_cast<std::uint32_t>(1 + i * (frames - kInSuccession) / (kRuns - 1));
    runs.push_back({first, first + static_cast<std::uint32_t>(kInSuccession) - 1});
  }
  return joined_runs(std::move(runs));
}

double updates_of(const BrickPart& part) {
  return static_cast<double>(count_frames(part.frames)) * static_cast<double>(planned_blocks(part));
}

/// An eighth of the bricks, those with more work more likely, evenly spread over the rest; as the memory allows.
PartGroup sampled_bricks(const PlannedScan& planned) {
  const std::size_t count = planned.parts.size();
  const std::size_t most = std::min(count, std::clamp<std::size_t>(count / 8, 3, 16));
  double all = 0;
  for (const BrickPart& part : planned.parts) all += updates_of(part);
  PartGroup sample;
  double before = 0;
  for (std::size_t i = 0; i < count; ++i) {
    before += updates_of(planned.parts[i]);
    const double due = (static_cast<double>(sample.size()) + 0.5) * all / static_cast<double>(most);
    if (sample.size() < most && before >= due) sample.push_back(i);
  }
  if (sample.empty()) sample.push_back(0);
  return first_group(planned, sample, sample.size());
}

/// Of one block, where the nodes above it are there already.
std::size_t block_memory() {
  VolumeMemory memory;
  memory.add({0, 0, 0});
  const std::size_t first = memory.most_bytes();
  memory.add({8, 0, 0});
  return memory.most_bytes() - first;
}

/// Of a part's volume without its blocks.
std::size_t memory_of_nodes(const BrickPart& part) {
  VolumeMemory memory;
  for (const openvdb::Coord& region : part.regions) memory.add(region);
  return memory.most_bytes() - part.regions.size() * block_memory();
}

class Calibration {
 public:
  Calibration(const OpenJob& job, const ScanJob& join, const fs::path& scratch, ScanSession& session)
      : job_(job), join_(join), scratch_(scratch), session_(session), sample_(sampled_bricks(job.planned)) {
    costs_.sampled = sample_.size();
  }

  [[nodiscard]] Result<void> read_frames() {
    const std::vector<FrameRun> runs = sampled_frames(job_.planned.trajectory.size());
    const RegionSet nowhere;
    auto volume = TsdfVolume::create(volume_config(job_.job.config.fusion));
    if (!volume) return volume.error();
    const double begin_s = processor_seconds();
    const auto read = for_each_planned(job_.job, job_.planned, runs, session_, [&](Frame& frame, std::uint32_t n) {
      const auto done = integrate_part(frame, job_.planned.trajectory[n - 1].T_world_camera, n, nowhere, *volume);
      return done ? Result<void>() : done.error();
    });
    if (!read) return read.error();
    if (!*read) return interrupted();
    costs_.frame_s = spent_since(begin_s) / static_cast<double>(count_frames(runs));
    costs_.process_mib = peak_rss_mib();
    const auto source = open_frames(job_.job);
    if (!source) return source.error();
    const std::size_t frames = std::max<std::size_t>(1, (*source)->info().frames);
    costs_.frame_bytes = bytes_in(job_.job.input) / static_cast<double>(frames);
    return {};
  }

  [[nodiscard]] Result<void> fuse_bricks() {
    double updates = 0, blocks = 0;
    std::vector<FrameRun> frames;
    for (const std::size_t number : sample_) {
      const BrickPart& part = job_.planned.parts[number];
      updates += updates_of(part);
      blocks += static_cast<double>(planned_blocks(part));
      frames.insert(frames.end(), part.frames.begin(), part.frames.end());
    }
    const double readings = static_cast<double>(count_frames(joined_runs(std::move(frames))));
    const double begin_s = processor_seconds();
    const auto fused = fuse_parts(
        job_.job, job_.planned, sample_, job_.folder.id(), [&](std::size_t n) { return file(n); }, session_);
    if (!fused) return fused.error();
    if (!*fused) return interrupted();
    const double left_s = spent_since(begin_s) - readings * costs_.frame_s;
    costs_.update_s = std::max(0.0, left_s) / std::max(1.0, updates);
    costs_.bytes_per_block = bytes_of(sample_) / std::max(1.0, blocks);
    return {};
  }

  /// Twice: a single brick tells what is to be done in any case.
  [[nodiscard]] Result<JobCosts> join_bricks() {
    DepthSamples samples;
    if (needs_samples(join_)) {
      auto read = samples_again(job_.job, job_.planned, session_);
      if (!read) return read.error();
      samples = *std::move(read);
    }
    const auto half = std::span(sample_).first(1);
    const auto few = join(half, samples);
    if (!few) return few.error();
    const auto all = join(sample_, samples);
    if (!all) return all.error();
    const double few_bytes = bytes_of(half), all_bytes = bytes_of(sample_);
    if (all_bytes > few_bytes) costs_.join_s_per_byte = std::max(0.0, *all - *few) / (all_bytes - few_bytes);
    costs_.join_start_s = std::max(0.0, *few - few_bytes * costs_.join_s_per_byte);
    if (needs_samples(join_)) costs_.join_start_s += costs_.frame_s * static_cast<double>(job_.planned.samples.size());
    return costs_;
  }

 private:
  [[nodiscard]] fs::path file(std::size_t number) const { return scratch_ / fmt::format("{}.brick", number); }

  [[nodiscard]] double bytes_of(std::span<const std::size_t> numbers) const {
    double bytes = 0;
    for (const std::size_t number : numbers) bytes += bytes_in(file(number));
    return bytes;
  }

  /// The seconds that it took. Bricks without a surface are no error.
  [[nodiscard]] Result<double> join(std::span<const std::size_t> numbers, const DepthSamples& samples) {
    BrickVolume bricks(job_.job.config.fusion);
    double blocks = 0;
    std::size_t node_bytes = 0;
    for (const std::size_t number : numbers) {
      if (auto added = bricks.add(file(number), job_.folder.id()); !added) return added.error();
      blocks += static_cast<double>(planned_blocks(job_.planned.parts[number]));
      node_bytes += memory_of_nodes(job_.planned.parts[number]);
    }
    ScanObserver silent;
    ScanSession session(silent, session_.stop());
    ScanResult result;
    result.trajectory = job_.planned.recorded_order();
    const double begin_s = processor_seconds();
    const auto joined = join_parts(join_, job_.planned.world_up, bricks, samples, archive_of(join_), session, result);
    const double spent_s = spent_since(begin_s);
    if (!joined && joined.error().code != ErrorCode::kMesh) return joined.error();
    if (session_.is_stopped()) return interrupted();
    const double block_bytes = result.volume.memory_mib * kBytesInMebibyte - static_cast<double>(node_bytes);
    costs_.memory_per_block = std::max(0.0, block_bytes) / std::max(1.0, blocks);
    costs_.triangles_per_byte =
        static_cast<double>(result.mesh.check ? result.mesh.check->triangles : 0) / std::max(1.0, bytes_of(numbers));
    return spent_s;
  }

  const OpenJob& job_;
  const ScanJob& join_;
  const fs::path& scratch_;
  ScanSession& session_;
  PartGroup sample_;
  JobCosts costs_;
};

}  // namespace

std::size_t planned_blocks(const BrickPart& part) {
  const std::size_t nodes = memory_of_nodes(part);
  return part.most_bytes > nodes ? (part.most_bytes - nodes) / block_memory() : part.regions.size();
}

Result<JobCosts> measure_costs(const OpenJob& job, const ScanJob& join, const fs::path& scratch, ScanSession& session) {
  Calibration calibration(job, join, scratch, session);
  if (auto read = calibration.read_frames(); !read) return read.error();
  if (auto fused = calibration.fuse_bricks(); !fused) return fused.error();
  return calibration.join_bricks();
}

}  // namespace scanknit
