#include "scan/lidar/scan_sweeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "acquire/lidar/sweep_grid.h"
#include "acquire/lidar/sweep_source.h"
#include "core/files/quantity.h"
#include "fusion/range/range_integrate.h"
#include "fusion/range/range_surface.h"
#include "fusion/range/range_view.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/checks/memory_share.h"
#include "scan/checks/settings_check.h"
#include "scan/frames/frame_intake.h"
#include "scan/mesh/finish_surface.h"
#include "scan/mesh/write_surface.h"
#include "scan/reconstruction.h"
#include "scan/two_digits.h"
#include "scan/volume/write_beside_mesh.h"

namespace scanknit {
namespace {

constexpr double kMinRange_m = 1;   // nearer is most often the vehicle
constexpr double kMaxRange_m = 50;  // farther, the lines of most scanners are too far apart for a surface

class SweepScan {
 public:
  SweepScan(const ScanJob& job, ScanObserver& observer, const std::stop_token& stop)
      : job_(job), session_(observer, stop) {}

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = scan();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

 private:
  [[nodiscard]] Result<void> scan() {
    warn_of_settings(job_, session_);
    if (auto sound = check_job(); !sound) return sound;
    if (auto opened = open(); !opened) return opened;
    choose_range();
    if (auto fused = fuse_all(); !fused) return fused;
    if (auto usable = conclude_frames(); !usable) return usable;
    result_.volume = described(*volume_);
    return write();
  }

  [[nodiscard]] Result<void> check_job() {
    if (auto writable = check_files(job_); !writable) return writable;
    if (job_.cut_recording || job_.angles || job_.config.turntable.is_enabled) {
      return Error{ErrorCode::kUsage, "options of a turntable do not apply to LiDAR sweeps"};
    }
    const PoseMode poses = job_.config.acquire.poses;
    if (poses != PoseMode::kAuto && poses != PoseMode::kRecording) {
      return Error{
          ErrorCode::kUsage,
          "LiDAR sweeps are fused at the poses that the recording has: set acquire.poses to recording or auto"};
    }
    if (job_.config.output.texture != TextureFormat::kOff) {
      session_.warn(WarningCode::kNoTexture, "LiDAR sweeps have no pictures: no texture is made");
      job_.config.output.texture = TextureFormat::kOff;
    }
    return {};
  }

  [[nodiscard]] Result<void> open() {
    auto opened = open_sweeps(job_.input, job_.config.acquire);
    if (!opened) return opened.error();
    source_ = *std::move(opened);
    const SweepInfo& info = source_->info();
    for (const std::string& warning : info.warnings) session_.warn(WarningCode::kRecording, warning);
    if (info.sweeps_with_pose == 0) {
      return Error{ErrorCode::kInput,
                   fmt::format("{} LiDAR sweeps without poses; expected {}", info.sweeps, info.expected_poses),
                   info.folder.string()};
    }
    if (job_.config.acquire.from >= info.sweeps) {
      return Error{ErrorCode::kInput,
                   fmt::format("from {} selects no sweep: the recording has {}, counted from 0",
                               job_.config.acquire.from, info.sweeps),
                   info.folder.string()};
    }
    session_.info(fmt::format("{} LiDAR sweeps ({}), {} with poses", info.sweeps, info.format, info.sweeps_with_pose));
    return {};
  }

  void choose_range() {
    AcquireConfig& acquire = job_.config.acquire;
    const bool is_chosen = !acquire.min_depth_m || !acquire.max_depth_m;
    if (!acquire.min_depth_m) acquire.min_depth_m = kMinRange_m;
    if (!acquire.max_depth_m) acquire.max_depth_m = kMaxRange_m;
    if (!is_chosen) return;
    session_.info(fmt::format("returns from {} to {} count; set acquire.min_depth and acquire.max_depth for others",
                              format_length(*acquire.min_depth_m), format_length(*acquire.max_depth_m)));
  }

  [[nodiscard]] Result<void> fuse_all() {
    const AcquireConfig& acquire = job_.config.acquire;
    const std::size_t last = std::min(acquire.to, source_->info().sweeps - 1);
    const std::size_t total = (last - acquire.from) / acquire.every + 1;
    for (std::size_t i = acquire.from; i <= last && !session_.is_stopped(); i += acquire.every) {
      auto event = session_.timed("acquire", [&] { return source_->read(i); });
      ++result_.frames.read;
      if (const auto* dropped = std::get_if<FrameDropped>(&event)) {
        count_drop(*dropped);
      } else if (auto fused = fuse(std::get<Sweep>(event)); !fused) {
        return fused;
      }
      session_.progress("fusing", result_.frames.read, total);
      if (volume_ && volume_->is_budget_reached) break;
      if (last - i < acquire.every) break;
    }
    return {};
  }

  void count_drop(const FrameDropped& dropped) {
    FrameCounts& frames = result_.frames;
    ++frames.dropped;
    ++frames.dropped_by_reason[to_string(dropped.reason)];
    if (frames.drop_messages.size() < FrameIntake::kMostDropMessages) {
      frames.drop_messages.push_back(dropped.error.text());
    }
  }

  [[nodiscard]] Result<void> fuse(const Sweep& sweep) {
    const AcquireConfig& acquire = job_.config.acquire;
    const SweepRange range{*acquire.min_depth_m, *acquire.max_depth_m};
    const RangeScan grid = session_.timed("filter", [&] { return grid_of(sweep, range); });
    const RangeSurface surface = session_.timed("filter", [&] { return find_surface(grid); });
    if (surface.triangles.empty()) {
      count_drop({sweep.sequence, DropReason::kNoDepth,
                  Error{ErrorCode::kInput, fmt::format("sweep {}: no surface within the range", sweep.sequence)}});
      return {};
    }
    if (!volume_) {
      choose_voxel_size(surface.spacing_m);
      auto created = TsdfVolume::create(volume_config(job_.config.fusion));
      if (!created) return created.error();
      volume_ = std::make_unique<TsdfVolume>(*std::move(created));
    }
    constexpr double kMostNoise_m = 0.05;  // what the grid shows beyond it is relief between the scanner's lines
    const RangeView view = session_.timed("filter", [&] { return RangeView(grid, surface); });
    const double noise_m = std::min(surface.noise_m, kMostNoise_m);
    const auto fused =
        session_.timed("integrate", [&] { return integrate(view, noise_m, sweep.T_world_sensor, *volume_); });
    if (!fused) return Error{fused.error().code, fmt::format("sweep {}: {}", sweep.sequence, fused.error().message)};
    ++result_.frames.fused;
    const double stamp =
        sweep.timestamp_ns ? static_cast<double>(*sweep.timestamp_ns) * 1e-9 : static_cast<double>(sweep.sequence);
    result_.trajectory.push_back({sweep.sequence, stamp, sweep.T_world_sensor});
    return {};
  }

  void choose_voxel_size(double spacing_m) {
    // A sweep's far points weigh little, but the sweeps that follow come near them.
    if (!job_.asks_for("extract.min_weight")) job_.config.extract.min_weight = 0;
    if (job_.asks_for("fusion.voxel_size")) return;
    constexpr double kFinest_m = 0.02, kCoarsest_m = 0.1;  // the key takes no more
    job_.config.fusion.voxel_size_m = std::clamp(two_digits(std::max(spacing_m, kFinest_m)), kFinest_m, kCoarsest_m);
    session_.info(
        fmt::format("fusion.voxel_size: {}, about the distance of the points; set fusion.voxel_size for another",
                    format_length(job_.config.fusion.voxel_size_m)));
  }

  [[nodiscard]] Result<void> conclude_frames() {
    const FrameCounts& frames = result_.frames;
    if (frames.fused == 0) {
      if (session_.is_stopped()) return Error{ErrorCode::kTooLittle, "interrupted before anything was fused: no mesh"};
      return Error{ErrorCode::kInput,
                   fmt::format("no usable sweep: all {} were dropped; the first: {}", frames.read,
                               frames.drop_messages.empty() ? "" : frames.drop_messages.front()),
                   job_.input.string()};
    }
    if (frames.dropped > 0) {
      session_.warn(WarningCode::kFramesDropped, fmt::format("{} of {} sweeps are not used: {}", frames.dropped,
                                                             frames.read, frames.drop_messages.front()));
    }
    if (session_.is_stopped()) {
      session_.warn(WarningCode::kStoppedEarly, "interrupted: the mesh holds only what was fused until then");
    }
    if (volume_->is_budget_reached) {
      session_.warn(
          WarningCode::kBudgetReached,
          "the volume has reached fusion.memory_budget: the mesh is incomplete. A larger fusion.voxel_size or "
          "a smaller acquire.max_depth needs less");
    }
    return {};
  }

  [[nodiscard]] Result<void> write() {
    auto written_beside = write_beside_mesh(*volume_, result_.trajectory, job_, session_, result_.files);
    if (!written_beside) return written_beside;
    const UpAxis world_up = source_->info().world_up;
    result_.mesh.isovalue = job_.config.extract.isovalue;
    const FinishedSurface finished = finished_surface(volume_->field_view().without_colours(),
                                                      {job_.config, world_up, 1, session_.stop()}, session_);
    add_to(result_.mesh, finished);
    if (!finished.outcome) return finished.outcome;
    WrittenSurface written =
        write_surface(finished.surface.mesh, {world_up, std::nullopt, std::nullopt}, job_, session_);
    const Result<void> outcome = written.outcome;
    add_to(result_.mesh, std::move(written));
    return outcome;
  }

  ScanJob job_;
  ScanSession session_;
  std::unique_ptr<SweepSource> source_;
  std::unique_ptr<TsdfVolume> volume_;  ///< made for the first sweep, which tells the voxel size
  ScanResult result_;
};

}  // namespace

ScanResult scan_sweeps(const ScanJob& job, ScanObserver& observer, std::stop_token stop) {
  return SweepScan(job, observer, stop).run();
}

}  // namespace scanknit
