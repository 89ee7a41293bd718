#include "scan/checks/budget_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "acquire/frame_source.h"
#include "acquire/rig/rig_config.h"
#include "core/files/quantity.h"
#include "fusion/integrate/block_counter.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/tsdf_volume.h"
#include "fusion/volume/volume_memory.h"
#include "scan/checks/memory_share.h"
#include "scan/frames/frame_archive.h"
#include "scan/frames/frame_count.h"
#include "scan/frames/recorded_frames.h"

namespace scanknit {
namespace {

constexpr std::size_t kSampleFrames = 20;

struct Selection {
  std::size_t of = 0;     ///< frames of the recording
  bool is_whole = false;  ///< true: all frames were selected
};

/// Reads some frames, evenly spread over the recording, and filters them as the run will: filters change the memory
/// that frames need by up to a half. Calls `visit` with each frame and its pose, until it returns false.
Selection visit_samples(const ScanJob& job, std::stop_token stop, const std::function<bool(Frame)>& visit) {
  const ScanConfig& config = job.config;
  Selection selection;
  const auto whole = open_recorded(job, config.acquire);
  if (!whole) return selection;
  selection.of = selected_frames((*whole)->info(), config.acquire);
  AcquireConfig sparse = config.acquire;
  std::size_t stride = std::max<std::size_t>(1, selection.of / kSampleFrames);
  while (job.rig && std::gcd(stride, job.rig->cameras.size()) > 1) --stride;  // else some cameras are never asked
  selection.is_whole = stride == 1;
  sparse.every *= stride;
  const auto source = open_recorded(job, sparse);
  if (!source) return selection;

  (void)for_each_frame(**source, stop, [&](Frame& frame) -> Result<Reading> {
    if (!frame.T_world_camera) return Reading::kContinue;
    frame.colour.reset();  // only depth is needed
    if (auto filtered = filter_frame(frame, config.acquire, config.fusion.noise); !filtered) return filtered.error();
    return visit(std::move(frame)) ? Reading::kContinue : Reading::kStop;
  });
  return selection;
}

/// Reads one frame at a time: most recordings fit, and twenty frames with their normals take 100 MB.
bool fits_by_count(const ScanJob& job, std::stop_token stop) {
  BlockCounter counter(job.config.fusion, volume_budget_mib(job.config.fusion.memory_budget_mib) << 20);
  visit_samples(job, stop, [&](const Frame& frame) {
    counter.add(frame, *frame.T_world_camera);
    return !counter.is_full();
  });
  return !counter.is_full();
}

struct Sample {
  std::vector<Frame> frames;
  Selection selection;
};

Sample sample_of(const ScanJob& job, std::stop_token stop) {
  Sample sample;
  sample.selection = visit_samples(job, stop, [&](Frame frame) {
    sample.frames.push_back(std::move(frame));
    return true;
  });
  return sample;
}

/// Counts the blocks that the frames may touch. Fast, but about a fifth too high: some of these blocks are never
/// observed.
bool fits_by_count(const std::vector<Frame>& frames, const FusionConfig& fusion, std::size_t max_bytes) {
  BlockCounter counter(fusion, max_bytes);
  for (const Frame& frame : frames) {
    counter.add(frame, *frame.T_world_camera);
    if (counter.is_full()) return false;
  }
  return true;
}

/// Fuses the frames and sees whether they stay within the budget.
bool fits_by_trial(const std::vector<Frame>& frames, const FusionConfig& fusion, std::size_t max_bytes) {
  auto volume = TsdfVolume::create(volume_config(fusion));
  if (!volume) return false;
  for (const Frame& frame : frames) {
    const auto fused = integrate(frame, *frame.T_world_camera, *volume);
    if (fused ? fused->is_budget_reached : fused.error().code == ErrorCode::kBudget) return false;
  }
  return volume->memory().most_bytes() <= max_bytes;
}

/// For large voxels a trial is as fast as the count, because there are few blocks. The count is far too high there:
/// wide bands touch distant blocks, whose inner nodes are counted but never kept.
bool fits(const std::vector<Frame>& frames, const FusionConfig& fusion, std::size_t spare_mib) {
  constexpr double kLarge_m = 0.01;
  const std::size_t max_bytes = (volume_budget_mib(fusion.memory_budget_mib) - spare_mib) << 20;
  return fits_by_count(frames, fusion, max_bytes) ||
         (fusion.voxel_size_m >= kLarge_m && fits_by_trial(frames, fusion, max_bytes));
}

/// The memory budget that the frames need: "about 1300 MiB"; "more than 8 GiB" of so many voxels that counting ends.
std::string budget_text(const std::vector<Frame>& frames, const FusionConfig& fusion) {
  constexpr std::size_t kMostBudgets = 16;
  const std::size_t most_mib = kMostBudgets * volume_budget_mib(fusion.memory_budget_mib);
  BlockCounter counter(fusion, most_mib << 20);
  for (const Frame& frame : frames) counter.add(frame, *frame.T_world_camera);
  const bool is_more = counter.is_full();
  const std::size_t volume_mib = is_more ? most_mib : (counter.most_bytes() >> 20) + 1;
  return (is_more ? "more than " : "about ") +
         format_memory_mib(static_cast<std::int64_t>(budget_for_volume_mib(volume_mib)));
}

/// Voxel sizes from 0.5 mm to 10 cm, each at most a fifth above the one before.
std::vector<double> round_sizes_mm() {
  constexpr int kDigits[] = {10, 12, 14, 16, 18, 20, 22, 25, 28, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 90};
  std::vector<double> sizes_mm;
  for (const double per_mm : {100.0, 10.0, 1.0}) {
    for (const int digits : kDigits) {
      if (digits / per_mm >= 0.5) sizes_mm.push_back(digits / per_mm);
    }
  }
  sizes_mm.push_back(100);
  return sizes_mm;
}

/// The finest round size that fits. Tries every fourth size until one fits, then the sizes that it skipped last.
std::optional<double> finest_fitting_size_mm(const std::vector<Frame>& frames, const FusionConfig& fusion,
                                             std::size_t spare_mib) {
  constexpr std::size_t kStep = 4;
  std::vector<double> sizes_mm = round_sizes_mm();
  std::erase_if(sizes_mm, [&](double size_mm) { return size_mm / 1000 <= fusion.voxel_size_m; });
  const auto fits_at = [&](std::size_t i) {
    FusionConfig coarser = fusion;
    coarser.voxel_size_m = sizes_mm[i] / 1000;
    return fits(frames, coarser, spare_mib);
  };
  for (std::size_t begin = 0; begin < sizes_mm.size(); begin += kStep) {
    const std::size_t last = std::min(begin + kStep, sizes_mm.size()) - 1;
    if (!fits_at(last)) continue;
    std::size_t i = begin;
    while (i < last && !fits_at(i)) ++i;
    return sizes_mm[i];
  }
  return std::nullopt;
}

/// The advice of the error message: a size that fits with an eighth of the budget to spare for frames that were not
/// sampled; else one that just fits.
std::string advice(const Sample& sample, const FusionConfig& fusion) {
  auto size_mm = finest_fitting_size_mm(
      sample.frames, fusion, sample.selection.is_whole ? 0 : volume_budget_mib(fusion.memory_budget_mib) / 8);
  const bool is_tight = !size_mm && !sample.selection.is_whole;
  if (is_tight) size_mm = finest_fitting_size_mm(sample.frames, fusion, 0);
  if (!size_mm) return "no voxel size up to 10 cm would fit: raise fusion.memory_budget, or lower acquire.max_depth";
  const std::string known = sample.selection.is_whole ? ""
                                                      : fmt::format(", judging by {} of its {} frames",
                                                                    sample.frames.size(), sample.selection.of);
  return fmt::format("{0} mm {1}{2}: set fusion.voxel_size={0}mm", format_number(*size_mm),
                     is_tight ? "might just fit" : "would fit", known);
}

}  // namespace

bool fits_into_budget(const ScanJob& job, std::stop_token stop) {
  return fits_by_count(job, stop) || fits(sample_of(job, stop).frames, job.config.fusion, 0);
}

Result<void> check_budget(const ScanJob& job, PoseMode poses, std::stop_token stop) {
  const FusionConfig& fusion = job.config.fusion;
  const auto volume = TsdfVolume::create(fusion);
  if (!volume) return volume.error();
  if (poses == PoseMode::kTrack) return {};
  if (fits_by_count(job, stop)) return {};
  const Sample sample = sample_of(job, stop);  // kept, because several sizes are tried on it
  if (fits(sample.frames, fusion, 0)) return {};
  return Error{
      ErrorCode::kBudget,
      fmt::format("this recording needs {} at {} voxels, more than fusion.memory_budget ({}); {}",
                  budget_text(sample.frames, fusion), format_length(fusion.voxel_size_m),
                  format_memory_mib(static_cast<std::int64_t>(fusion.memory_budget_mib)), advice(sample, fusion))};
}

}  // namespace scanknit
