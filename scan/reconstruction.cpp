#include "scan/reconstruction.h"

#include <fmt/format.h>

#include "acquire/filter/depth_filter.h"
#include "fusion/integrate/integrate.h"

namespace scanknit {

Result<Reconstruction> Reconstruction::create(const ScanConfig& config, const Options& options, PoseRefiner& refiner,
                                              ScanSession& session) {
  auto volume = TsdfVolume::create(config.fusion);
  if (!volume) return volume.error();
  return Reconstruction(config, options, refiner, session, *std::move(volume));
}

Result<Reconstruction::Added> Reconstruction::add(Frame& frame) {
  const auto filtered =
      session_.timed("filter", [&] { return filter_frame(frame, config_.acquire, config_.fusion.noise); });
  if (!filtered) return filtered.error();
  refiner_.edit_for_tracking(frame);
  const std::optional<Pose> T_world_camera = poses_.find(frame, volume_, session_);
  if (!T_world_camera) {
    follows_gap_ = true;
    return Added{};
  }
  const auto fused = session_.timed("integrate", [&] { return integrate(frame, *T_world_camera, volume_); });
  if (!fused && fused.error().code == ErrorCode::kInput) return Added{std::nullopt, fused.error()};
  if (!fused) return fused.error();
  note_fused(frame, *T_world_camera, fused->is_budget_reached);
  return Added{T_world_camera};
}

void Reconstruction::note_fused(const Frame& frame, const Pose& T_world_camera, bool is_budget_reached) {
  trajectory_.push_back({frame.sequence, stamp_of(frame), T_world_camera});
  if (is_budget_reached && !std::exchange(is_budget_reached_, true)) {
    session_.warn(WarningCode::kBudgetReached,
                  fmt::format("frame {}: the volume has reached fusion.memory_budget and grows no further; what it "
                              "holds is still refined",
                              frame.sequence));
  }
  refiner_.note_fused(frame, T_world_camera, std::exchange(follows_gap_, false));
  if (options_.keeps_depth_samples) samples_.add(frame);
}

Result<void> Reconstruction::start_over() {
  auto volume = TsdfVolume::create(config_.fusion);
  if (!volume) return volume.error();
  volume_ = *std::move(volume);
  poses_ = PoseFinder(options_.poses);
  trajectory_.clear();
  samples_.clear();
  follows_gap_ = false;
  is_budget_reached_ = false;
  refiner_.start_over();
  return {};
}

void Reconstruction::replace(TsdfVolume volume, Trajectory trajectory) {
  volume_ = std::move(volume);
  trajectory_ = std::move(trajectory);
}

VolumeResult described(const TsdfVolume& volume) {
  constexpr double kBytesPerMebibyte = 1024.0 * 1024.0;
  VolumeResult result;
  result.active_voxels = volume.active_voxels();
  result.blocks = volume.blocks();
  result.memory_mib = static_cast<double>(volume.memory_bytes()) / kBytesPerMebibyte;
  result.voxel_size_m = volume.config().voxel_size_m;
  result.is_budget_reached = volume.is_budget_reached;
  return result;
}

}  // namespace scanknit
