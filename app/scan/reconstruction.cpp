#include "app/scan/reconstruction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "acquire/filter/depth_filter.h"
#include "app/scan/mesh_output.h"
#include "app/scan/retrack.h"
#include "app/scan/stage_timer.h"
#include "core/files/atomic_file.h"
#include "fusion/integrate/integrate.h"

namespace scanknit {
namespace {

constexpr double kWorthFusing = 0.1;  // voxels: poses that change less than this are not worth fusing all frames again

/// The samples within the box.
openvdb::CoordBBox index_box(const Eigen::AlignedBox3d& box, double voxel_size_m) {
  const auto index = [&](double metres, double (*round)(double)) {
    constexpr double kFarthest = 1e9;  // a box may reach far beyond any volume
    return static_cast<int>(std::clamp(round(metres / voxel_size_m), -kFarthest, kFarthest));
  };
  const auto first = [&](int axis) { return index(box.min()[axis], std::ceil); };
  const auto last = [&](int axis) { return index(box.max()[axis], std::floor); };
  return {{first(0), first(1), first(2)}, {last(0), last(1), last(2)}};
}

double farthest_moved_m(const std::vector<StampedPose>& from, const std::vector<Pose>& to) {
  double farthest_m = 0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const Eigen::Vector3d moved = to[i].translation() - from[i].T_world_camera.translation();
    farthest_m = std::max(farthest_m, moved.norm());
  }
  return farthest_m;
}

}  // namespace

Result<Reconstruction> Reconstruction::create(const Job& job, const RecordingInfo& info, FrameIntake& intake,
                                              RunReport& report) {
  auto volume = TsdfVolume::create(job.config.fusion);
  if (!volume) return volume.error();
  return Reconstruction(job, info, intake, report, *std::move(volume));
}

void Reconstruction::expect_loops() {
  fused_.clear();
  samples_.clear();
  keys_.reset();
  was_lost_ = false;
  if (info_.poses == PoseMode::kTrack && job_.config.fusion.loop_closure) keys_.emplace(job_.config.fusion.noise);
}

void Reconstruction::note_for_loops(const Frame& frame, const Pose& T_world_camera) {
  fused_.push_back(frame.sequence);
  if (keys_) timed(report_, "key_frames", [&] { keys_->add(frame, T_world_camera, was_lost_); });
  was_lost_ = false;
}

Result<std::optional<Pose>> Reconstruction::add(Frame& frame) {
  timed(report_, "filter", [&] { filter_frame(frame, job_.config.acquire, job_.config.fusion.noise); });
  if (edit_) edit_(frame);
  const std::optional<Pose> T_world_camera = poses_.find(frame, volume_, report_);
  if (!T_world_camera) {
    was_lost_ = true;
    return T_world_camera;
  }
  const auto fused = timed(report_, "integrate", [&] { return integrate(frame, *T_world_camera, volume_); });
  if (!fused && fused.error().code == ErrorCode::kInput) {
    intake_.note_refused(frame, fused.error());
    return std::optional<Pose>();
  }
  if (!fused) return fused.error();
  intake_.note_fused(frame, *T_world_camera, fused->is_budget_reached);
  note_for_loops(frame, *T_world_camera);
  if (job_.outputs.report) samples_.add(frame);
  return T_world_camera;
}

Result<void> Reconstruction::start_over() {
  auto volume = TsdfVolume::create(job_.config.fusion);
  if (!volume) return volume.error();
  volume_ = *std::move(volume);
  poses_ = PoseFinder(info_.poses);
  expect_loops();
  intake_.start_over();
  return {};
}

std::optional<LoopClosure> Reconstruction::find_loops() {
  if (!keys_) return std::nullopt;
  const FusionConfig& fusion = job_.config.fusion;
  return timed(report_, "loops", [&] { return close_loops(*keys_, fusion.noise, kWorthFusing * fusion.voxel_size_m); });
}

Result<void> Reconstruction::track_again(const FrameRange& frames, FrameSource& source, std::stop_token stop) {
  const auto sequences = std::span(fused_).subspan(frames.first, frames.last - frames.first + 1);
  const auto poses = timed(report_, "loops", [&] { return track_alone(source, sequences, job_.config, stop); });
  if (!poses) return poses.error();
  keys_->replace(frames.first, *poses);
  return {};
}

Result<double> Reconstruction::fuse_at(const std::vector<Pose>& T_world_cameras, FrameSource& source,
                                       std::stop_token stop, Console& console) {
  PosesBySequence poses;
  for (std::size_t i = 0; i < fused_.size(); ++i) poses.emplace(fused_[i], T_world_cameras[i]);
  auto empty = TsdfVolume::create(job_.config.fusion);
  if (!empty) return empty.error();
  volume_ = *std::move(empty);
  const auto fused =
      timed(report_, "fuse_again", [&] { return fuse_again(source, poses, job_.config, volume_, stop, console); });
  if (!fused) return fused.error();
  if (*fused != poses.size()) {
    return Error{ErrorCode::kInput, fmt::format("only {} of {} frames could be read again", *fused, poses.size())};
  }
  const double moved_m = farthest_moved_m(intake_.trajectory(), T_world_cameras);
  intake_.correct(T_world_cameras);
  return moved_m;
}

Result<FinishedSurface> Reconstruction::surface(EmptyCrop empty_crop, RunReport& report) const {
  const auto extract = [&](const std::optional<Eigen::AlignedBox3d>& crop) {
    FieldView view = volume_.field_view();
    if (crop) view.region = index_box(*crop, volume_.config().voxel_size_m);
    return finished_surface(view, job_.config, info_.world_up, report, intake_.stop());
  };
  auto cropped = extract(crop_);
  if (!cropped || !crop_ || !cropped->surface.mesh.empty()) return cropped;
  if (empty_crop == EmptyCrop::kRefused) {
    return Error{ErrorCode::kMesh, "nothing lies within the crop box of the live view: clear it, or make it larger"};
  }
  auto whole = extract(std::nullopt);
  if (!whole || whole->surface.mesh.empty()) return whole;
  std::vector<std::string>& warnings = report.warnings;  // the mesh may be written more than once
  if (std::find(warnings.begin(), warnings.end(), kCropIgnored) == warnings.end()) warnings.emplace_back(kCropIgnored);
  return whole;
}

Result<WrittenMesh> Reconstruction::write_mesh(RunReport& report, EmptyCrop empty_crop) const {
  const auto& trajectory = intake_.trajectory();
  if (trajectory.empty()) return Error{ErrorCode::kTooLittle, "nothing has been fused yet"};
  report.extract.isovalue = job_.config.extract.isovalue;
  report.extract.isovalue_source = "config";
  auto meshed = surface(empty_crop, report);
  if (!meshed) return meshed.error();
  // Seen from where the scanner stood half way through the scan.
  const Pose& T_world_scanner = trajectory[trajectory.size() / 2].T_world_camera;
  MeshFrame frame{info_.world_up, meshed->T_mesh_world * T_world_scanner, std::nullopt};
  frame.depths = samples_.posed(trajectory, intake_.fused_sequences());
  for (PosedDepth& depth : frame.depths) depth.T_world_camera = meshed->T_mesh_world * depth.T_world_camera;
  if (auto written = write_surface(meshed->surface, frame, job_, report); !written) return written.error();
  WrittenMesh written{{}, info_.world_up, {}};
  if (job_.config.output.texture == TextureFormat::kOff) return written;
  written.mesh = std::move(meshed->surface.mesh);
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    written.T_mesh_camera[intake_.fused_sequences()[i]] = meshed->T_mesh_world * trajectory[i].T_world_camera;
  }
  return written;
}

Result<void> Reconstruction::write_volume() {
  if (!job_.outputs.volume) return {};
  report_.files["volume"] = job_.outputs.volume->string();
  return timed(report_, "write", [&] { return volume_.save(*job_.outputs.volume); });
}

Result<void> Reconstruction::write_trajectory() {
  if (!job_.outputs.trajectory) return {};
  report_.files["trajectory"] = job_.outputs.trajectory->string();
  const std::string text = to_tum_trajectory(intake_.trajectory());
  return timed(report_, "write", [&] { return write_file_atomically(*job_.outputs.trajectory, text); });
}

}  // namespace scanknit
