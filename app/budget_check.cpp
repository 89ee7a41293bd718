#include "app/budget_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "acquire/depth_filter.h"
#include "acquire/frame_source.h"
#include "app/frame_count.h"
#include "app/quantity.h"
#include "fusion/integrate.h"
#include "fusion/tsdf_volume.h"

namespace scanknit {
namespace {

constexpr std::size_t kSampleFrames = 20;

std::vector<Frame> sample_frames(const std::filesystem::path& recording, const AcquireConfig& acquire,
                                 std::stop_token stop) {
  const auto whole = open_recording(recording, acquire);
  if (!whole) return {};
  AcquireConfig sparse = acquire;
  sparse.every = acquire.every * std::max<std::size_t>(1, selected_frames((*whole)->info(), acquire) / kSampleFrames);
  const auto source = open_recording(recording, sparse);
  if (!source) return {};

  std::vector<Frame> frames;
  while (true) {
    FrameEvent event = (*source)->next(stop);
    if (std::holds_alternative<EndOfStream>(event) || std::holds_alternative<Error>(event)) return frames;
    auto* frame = std::get_if<Frame>(&event);
    if (frame == nullptr || !frame->T_world_camera) continue;
    frame->colour.reset();  // only depth is asked for
    frame->depth_m = clip_range(frame->depth_m, acquire.min_depth_m, acquire.max_depth_m);
    frames.push_back(std::move(*frame));
  }
}

bool fits(const std::vector<Frame>& frames, const FusionConfig& fusion, std::size_t max_bytes) {
  BlockCounter counter(fusion, max_bytes);
  for (const Frame& frame : frames) {
    counter.add(frame, *frame.T_world_camera);
    if (counter.is_full()) return false;
  }
  return true;
}

/// The finest round voxel size that fits: with a quarter of room for the frames that were not looked at, else just so.
std::optional<double> fitting_voxel_size_m(const std::vector<Frame>& frames, const FusionConfig& fusion,
                                           std::size_t max_bytes) {
  constexpr double kRoundSizesM[] = {0.0005, 0.00075, 0.001, 0.0015, 0.002, 0.003, 0.004, 0.005, 0.0075,
                                     0.01,   0.015,   0.02,  0.03,   0.04,  0.05,  0.075, 0.1};
  for (const std::size_t bytes : {max_bytes - max_bytes / 4, max_bytes}) {
    for (const double size_m : kRoundSizesM) {
      FusionConfig coarser = fusion;
      coarser.voxel_size_m = size_m;
      if (size_m > fusion.voxel_size_m && fits(frames, coarser, bytes)) return size_m;
    }
  }
  return std::nullopt;
}

}  // namespace

Result<void> check_budget(const std::filesystem::path& recording, PoseMode poses, const Config& config,
                          std::stop_token stop) {
  const auto volume = TsdfVolume::create(config.fusion);
  if (!volume) return volume.error();
  if (poses == PoseMode::kTrack) return {};
  const std::size_t max_bytes = config.fusion.memory_budget_mib << 20;
  const std::vector<Frame> frames = sample_frames(recording, config.acquire, stop);
  if (fits(frames, config.fusion, max_bytes)) return {};

  const auto size_m = fitting_voxel_size_m(frames, config.fusion, max_bytes);
  const auto budget_mib = static_cast<std::int64_t>(config.fusion.memory_budget_mib);
  std::string message = fmt::format("this recording needs more than {} at {} voxels (fusion.memory_budget)",
                                    format_memory_mib(budget_mib), format_length(config.fusion.voxel_size_m));
  if (size_m) {
    message += fmt::format("; {} would fit: --set fusion.voxel_size={}mm", format_length(*size_m),
                           format_number(*size_m * 1000));
  } else {
    message += "; no voxel size up to 10 cm would fit: --set fusion.memory_budget=... or a smaller acquire.max_depth";
  }
  return Error{ErrorCode::kBudget, message};
}

}  // namespace scanknit
