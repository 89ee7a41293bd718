#include "scan/silhouettes/scan_silhouettes.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/files/quantity.h"
#include "scan/checks/memory_share.h"
#include "scan/checks/settings_check.h"
#include "scan/mesh/finish_surface.h"
#include "scan/mesh/write_surface.h"
#include "scan/reconstruction.h"
#include "scan/silhouettes/silhouette_views.h"
#include "scan/silhouettes/turned_views.h"
#include "scan/two_digits.h"
#include "scan/volume/write_beside_mesh.h"

namespace scanknit {
namespace {

class SilhouetteScan {
 public:
  SilhouetteScan(const ScanJob& job, ScanObserver& observer, const std::stop_token& stop)
      : job_(job), session_(observer, stop) {}

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = scan();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

 private:
  [[nodiscard]] Result<void> scan() {
    warn_of_settings(job_, session_);
    if (auto sound = check_job(); !sound) return sound;
    if (auto read = read_pictures(); !read) return read;
    if (auto turned = find_turntable(); !turned) return turned;
    note_trajectory();
    const auto box = session_.timed("prepare", [&] { return hull_box(read_.views); });
    if (!box) return located_in_input(box.error());
    choose_voxel_size(*box);
    auto volume = TsdfVolume::create(volume_config(job_.config.fusion));
    if (!volume) return volume.error();
    if (auto carved = carve(*box, *volume); !carved) return carved;
    if (session_.is_stopped()) return Error{ErrorCode::kTooLittle, "interrupted before the mesh was made"};
    return write(*volume);
  }

  [[nodiscard]] Result<void> check_job() {
    if (auto writable = check_files(job_); !writable) return writable;
    if (job_.cut_recording) return Error{ErrorCode::kUsage, "a cut recording has depth: silhouettes have none"};
    if (job_.angles && !job_.config.turntable.is_enabled) {
      return Error{ErrorCode::kUsage, "angles are known only of a turntable: set turntable.enabled"};
    }
    if (job_.config.output.texture != TextureFormat::kOff) {
      session_.warn(WarningCode::kNoTexture, "a visual hull gets colours at its vertices: no texture is made");
      job_.config.output.texture = TextureFormat::kOff;
    }
    return {};
  }

  [[nodiscard]] Result<void> located_in_input(const Error& error) const {
    return Error{error.code, error.message, job_.input.string()};
  }

  [[nodiscard]] Result<void> read_pictures() {
    auto set = open_pictures(job_.input, job_.config.acquire);
    if (!set) return set.error();
    for (const std::string& warning : set->warnings) session_.warn(WarningCode::kRecording, warning);
    world_up_ = set->world_up;
    has_poses_ = set->has_poses;
    if (!has_poses_ && !job_.config.turntable.is_enabled) {
      return Error{ErrorCode::kInput,
                   "the pictures have no poses: add trajectory.log, or trajectory.txt in TUM's format, or, if a thing "
                   "turned before a camera that stood still, set turntable.enabled",
                   job_.input.string()};
    }
    auto read = read_silhouettes(*set, job_.config, session_);
    if (!read) return read.error();
    read_ = *std::move(read);
    result_.frames = read_.frames;
    result_.frames.fused = read_.views.size();
    if (read_.frames.dropped > 0) {
      session_.warn(WarningCode::kFramesDropped, fmt::format("{} of {} pictures are not used: {}", read_.frames.dropped,
                                                             read_.frames.read, read_.frames.drop_messages.front()));
    }
    return {};
  }

  /// The camera's poses round a thing on a turntable.
  [[nodiscard]] Result<void> find_turntable() {
    if (has_poses_) return {};
    const TurntableConfig& known = job_.config.turntable;
    constexpr double kAssumed_m = 1;
    if (!known.distance_m) {
      session_.warn(WarningCode::kTurntable,
                    "the size of the thing is not known: the axis is taken to be 1 m before the camera. Set "
                    "turntable.distance");
    }
    return session_.timed("refine", [&]() -> Result<void> {
      auto turned = turn_views(job_, known.distance_m.value_or(kAssumed_m), read_);
      if (!turned) return located_in_input(turned.error());
      session_.info(
          fmt::format("turntable: axis found; outlines miss one another by {:.2f} pixels, turned the other way "
                      "by {:.2f}",
                      turned->axis.off_px, turned->axis.other_off_px));
      constexpr double kClear = 1.5;
      if (turned->axis.other_off_px < kClear * turned->axis.off_px) {
        session_.warn(WarningCode::kTurntable,
                      "the silhouettes hardly tell in which direction the thing turned: the mesh may be mirrored. Take "
                      "pictures from nearer, or from above");
      }
      result_.turntable = std::move(turned->table);
      return {};
    });
  }

  void note_trajectory() {
    for (std::size_t i = 0; i < read_.views.size(); ++i) {
      result_.trajectory.push_back(
          {read_.numbers[i], static_cast<double>(read_.numbers[i]), read_.views[i].T_world_camera});
    }
  }

  void choose_voxel_size(const Eigen::AlignedBox3d& box) {
    if (job_.asks_for("fusion.voxel_size")) return;
    constexpr double kMostVoxels = 400;  // along the longest side
    const double finest = box.sizes().maxCoeff() / kMostVoxels;
    job_.config.fusion.voxel_size_m =
        std::clamp(two_digits(std::max(finest, pixel_size_m(read_, box.center()))), 0.00001, 0.1);
    session_.info(
        fmt::format("fusion.voxel_size: {}, about the size of a pixel on the thing; set fusion.voxel_size for another",
                    format_length(job_.config.fusion.voxel_size_m)));
  }

  [[nodiscard]] Result<void> carve(const Eigen::AlignedBox3d& box, TsdfVolume& volume) {
    const double band_m = volume.tsdf().background();
    session_.timed("filter", [&] { reach_band(box, band_m, read_); });
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(band_m);
    const Eigen::AlignedBox3d around(box.min() - margin, box.max() + margin);
    const auto carved = session_.timed("integrate", [&] { return carve_hull(read_.views, around, volume); });
    if (!carved) return carved.error();
    if (volume.is_budget_reached) {
      session_.warn(WarningCode::kBudgetReached, "the volume has reached fusion.memory_budget: the mesh is incomplete");
    }
    session_.timed("colour", [&] { paint(volume); });
    result_.silhouettes = session_.timed("agreement", [&] { return agreement_of(read_, volume, session_); });
    result_.volume = described(volume);
    return {};
  }

  void paint(TsdfVolume& volume) const {
    std::vector<ColourOfView> colours;
    for (std::size_t i = 0; i < read_.views.size(); ++i) {
      colours.push_back({&read_.pictures[i].colour, read_.views[i].camera, read_.views[i].T_world_camera});
    }
    paint_hull(colours, volume);
  }

  [[nodiscard]] Result<void> write(const TsdfVolume& volume) {
    auto written_beside = write_beside_mesh(volume, result_.trajectory, job_, session_, result_.files);
    if (!written_beside) return written_beside;
    result_.mesh.isovalue = job_.config.extract.isovalue;
    const FinishedSurface finished =
        finished_surface(volume.field_view(), {job_.config, world_up_, 1, session_.stop()}, session_);
    add_to(result_.mesh, finished);
    if (!finished.outcome) return finished.outcome;
    const Pose viewpoint = finished.T_mesh_world() * read_.views.front().T_world_camera;
    WrittenSurface written = write_surface(finished.surface.mesh, {world_up_, viewpoint, std::nullopt}, job_, session_);
    const Result<void> outcome = written.outcome;
    add_to(result_.mesh, std::move(written));
    return outcome;
  }

  ScanJob job_;
  ScanSession session_;
  UpAxis world_up_ = UpAxis::kMinusY;
  bool has_poses_ = true;
  SilhouettePictures read_;
  ScanResult result_;
};

}  // namespace

ScanResult scan_silhouettes(const ScanJob& job, ScanObserver& observer, std::stop_token stop) {
  return SilhouetteScan(job, observer, stop).run();
}

}  // namespace scanknit
