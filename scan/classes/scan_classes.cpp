#include "scan/classes/scan_classes.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "acquire/filter/depth_filter.h"
#include "acquire/masks/found_masks.h"
#include "core/files/atomic_file.h"
#include "core/mesh/mesh_area.h"
#include "export/trajectory.h"
#include "fusion/shutter/deskew.h"
#include "scan/checks/settings_check.h"
#include "scan/classes/class_volumes.h"
#include "scan/frames/apply_sensor.h"
#include "scan/frames/frame_intake.h"
#include "scan/frames/recorded_frames.h"
#include "scan/mesh/finish_surface.h"
#include "scan/mesh/mesh_scan.h"
#include "scan/mesh/write_surface.h"
#include "scan/passes.h"
#include "scan/reconstruction.h"
#include "scan/volume/write_beside_mesh.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// "model_class3.glb" of "model.glb".
fs::path of_class(const fs::path& path, int label) {
  fs::path name = path.stem();
  name += fmt::format("_class{}", label);
  name += path.extension();
  return path.parent_path() / name;
}

/// Without the trajectory, which all classes share.
ScanFiles files_of_class(ScanFiles files, int label) {
  for (fs::path& mesh : files.meshes) mesh = of_class(mesh, label);
  for (auto* path : {&files.preview, &files.error, &files.coverage, &files.volume}) {
    if (*path) *path = of_class(**path, label);
  }
  files.trajectory.reset();
  return files;
}

class ClassScan {
 public:
  ClassScan(const ScanJob& job, ScanObserver& observer, const std::stop_token& stop)
      : job_(job),
        session_(observer, stop),
        classes_(job_.config, job_.measures_fit || job_.config.finish.drops_crumbs || job_.config.output.uncertainty) {
    job_.config.acquire.keeps_labels = true;
    job_.config.acquire.mask_class.reset();
  }

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = scan();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

 private:
  [[nodiscard]] Result<void> scan() {
    warn_of_settings(job_, session_);
    if (auto sound = check_job(); !sound) return sound;
    if (auto opened = open(); !opened) return opened;
    if (auto tracked = track(); !tracked) return tracked;
    if (auto fused = fuse_all(); !fused) return fused;
    return write_all();
  }

  [[nodiscard]] Result<void> check_job() {
    if (auto writable = check_files(job_); !writable) return writable;
    if (job_.config.acquire.geometry == Geometry::kSilhouettes) {
      return Error{ErrorCode::kUsage,
                   "silhouettes are carved one class at a time: set acquire.mask_class to one of them"};
    }
    if (mask_origin(job_.config.acquire) != MaskOrigin::kFiles) {
      return Error{
          ErrorCode::kUsage,
          "a mesh for each class needs masks: set acquire.masks to their folder, as seen from the recording's"};
    }
    if (job_.config.fusion.silhouettes == SilhouetteUse::kCarve) {
      return Error{ErrorCode::kUsage, "silhouettes fill one class at a time: set acquire.mask_class to one of them"};
    }
    if (job_.cut_recording || job_.angles || job_.config.turntable.is_enabled) {
      return Error{ErrorCode::kUsage,
                   "a turntable's classes are scanned one at a time: set acquire.mask_class to one of them"};
    }
    if (job_.config.output.texture != TextureFormat::kOff) {
      session_.warn(WarningCode::kNoTexture, "meshes of classes get no texture: their colours are those of vertices");
      job_.config.output.texture = TextureFormat::kOff;
    }
    return {};
  }

  [[nodiscard]] Result<void> open() {
    auto opened = open_frames(job_);
    if (!opened) return opened.error();
    source_ = *std::move(opened);
    for (const std::string& warning : source_->info().warnings) session_.warn(WarningCode::kRecording, warning);
    (void)apply_sensor(source_->info().sensor, job_.config, session_);
    return session_.observer().on_open(source_->info());
  }

  /// Finds poses that the recording does not have, by all depth.
  [[nodiscard]] Result<void> track() {
    if (!is_tracked(source_->info().poses)) return {};
    ScanJob whole = job_;
    whole.files = {};
    whole.measures_fit = false;
    whole.config.acquire.masks.reset();
    whole.config.acquire.keeps_labels = false;
    auto frames = open_frames(whole);
    if (!frames) return frames.error();
    const FrameArchive archive = archive_of(whole);
    PassResult tracked = scan_walk(whole, {.source = **frames, .archive = archive, .stop = session_.stop()}, session_);
    result_ = std::move(tracked.scan);
    result_.mesh = {};
    return result_.outcome;
  }

  [[nodiscard]] Result<void> fuse_all() {
    for (const PosedFrame& frame : result_.trajectory) tracked_[frame.sequence] = frame;
    result_.trajectory.clear();
    FrameIntake intake(*source_, job_.config.acquire, session_, {session_.stop()});
    while (!intake.is_over()) {
      auto frame = intake.next();
      if (!frame) continue;
      const auto added = fuse(*frame);
      if (!added) return added.error();
      intake.count(*frame, *added);
    }
    result_.frames = intake.counts();
    if (classes_.has_left_out()) {
      session_.warn(WarningCode::kClasses,
                    fmt::format("the masks have more than {} classes: the others are left out", kMostClasses));
    }
    return intake.conclude();
  }

  [[nodiscard]] Result<Reconstruction::Added> fuse(Frame& frame) {
    const auto posed = pose_of(frame);
    if (!posed) return Reconstruction::Added{};
    const auto filtered =
        session_.timed("filter", [&] { return filter_frame(frame, job_.config.acquire, job_.config.fusion.noise); });
    if (!filtered) return filtered.error();
    deskew(posed->motion, frame);
    const auto fused = session_.timed("integrate", [&] { return classes_.integrate(frame, posed->T_world_camera); });
    if (!fused && fused.error().code == ErrorCode::kInput) return Reconstruction::Added{std::nullopt, fused.error()};
    if (!fused) return fused.error();
    result_.trajectory.push_back(*posed);
    return Reconstruction::Added{posed->T_world_camera};
  }

  /// Nothing: the frame was lost.
  [[nodiscard]] std::optional<PosedFrame> pose_of(const Frame& frame) const {
    if (!is_tracked(source_->info().poses)) return PosedFrame{frame.sequence, stamp_of(frame), *frame.T_world_camera};
    const auto found = tracked_.find(frame.sequence);
    return found == tracked_.end() ? std::nullopt : std::optional(found->second);
  }

  [[nodiscard]] Result<void> write_all() {
    if (job_.files.trajectory) {
      result_.files["trajectory"] = job_.files.trajectory->string();
      const std::string text = trajectory_text(*job_.files.trajectory, stamped_poses(result_.trajectory));
      auto written = session_.timed("write", [&] { return write_file_atomically(*job_.files.trajectory, text); });
      if (!written) return written;
    }
    result_.volume = {};
    std::size_t meshes = 0;
    std::string why = "expected pixels with values other than 0";
    auto& classes = classes_.all();
    for (; !classes.empty(); classes.erase(classes.begin())) {
      const int label = classes.begin()->first;
      ClassResult& made = result_.classes.emplace_back();
      made.label = label;
      const Result<void> written = write(classes.begin()->second, made);
      count(made);
      if (!written && written.error().code != ErrorCode::kMesh) return written;
      meshes += written ? 1 : 0;
      if (!written) {
        why = fmt::format("class {}: no mesh: {}", label, written.error().message);
        session_.warn(WarningCode::kClasses, why);
      }
    }
    if (meshes > 0) return {};
    return Error{ErrorCode::kMesh, "no class of the masks has a mesh: " + why, job_.input.string()};
  }

  [[nodiscard]] Result<void> write(const ClassVolume& one, ClassResult& made) {
    ScanJob job = job_;
    job.files = files_of_class(job_.files, made.label);
    made.volume = described(one.volume);
    const std::vector<PosedDepth> samples = one.samples.posed(result_.trajectory);
    const auto sigma_m = view_sigma_m(one.volume, samples, job.config);
    if (auto saved = write_beside_mesh(one.volume, {}, job, session_, made.mesh.files, sigma_m); !saved) return saved;
    const FilesByKind beside = made.mesh.files;
    const UpAxis world_up = source_->info().world_up;
    made.mesh.isovalue = job.config.extract.isovalue;
    FinishedSurface finished = finished_surface(one.volume.field_view(),
                                                {job.config, world_up, 1, session_.stop(), samples, sigma_m}, session_);
    add_to(made.mesh, finished);
    if (!finished.outcome) return finished.outcome;
    made.area_m2 = area_m2(finished.surface.mesh);
    MeshFrame frame = frame_of(samples, finished.T_mesh_world());
    frame.uncertainty_m = std::move(finished.uncertainty_m);
    WrittenSurface written = write_surface(finished.surface.mesh, frame, job, session_);
    const Result<void> outcome = written.outcome;
    add_to(made.mesh, std::move(written));
    made.mesh.files.insert(beside.begin(), beside.end());
    return outcome;
  }

  [[nodiscard]] MeshFrame frame_of(const std::vector<PosedDepth>& samples, const Pose& T_mesh_world) const {
    // The preview's viewpoint: where the scanner was half way through the scan.
    const Pose& T_world_scanner = result_.trajectory[result_.trajectory.size() / 2].T_world_camera;
    MeshFrame frame{source_->info().world_up, T_mesh_world * T_world_scanner, std::nullopt, {}};
    if (job_.measures_fit) frame.depths = samples;
    for (PosedDepth& depth : frame.depths) depth.T_world_camera = T_mesh_world * depth.T_world_camera;
    return frame;
  }

  /// Adds what one class made to the whole.
  void count(const ClassResult& made) {
    VolumeResult& all = result_.volume;
    all.active_voxels += made.volume.active_voxels;
    all.blocks += made.volume.blocks;
    all.memory_mib += made.volume.memory_mib;
    all.voxel_size_m = made.volume.voxel_size_m;
    all.is_budget_reached = all.is_budget_reached || made.volume.is_budget_reached;
    if (made.volume.is_budget_reached) {
      session_.warn(WarningCode::kBudgetReached,
                    "the volumes of the classes have reached fusion.memory_budget, which they share: meshes are "
                    "incomplete; a larger fusion.voxel_size needs less");
    }
    result_.mesh.warnings.insert(result_.mesh.warnings.end(), made.mesh.warnings.begin(), made.mesh.warnings.end());
    for (const auto& [kind, path] : made.mesh.files) {
      result_.files[fmt::format("{}_class{}", kind, made.label)] = path;
    }
  }

  ScanJob job_;
  ScanSession session_;
  ClassVolumes classes_;
  std::unique_ptr<FrameSource> source_;
  std::map<std::uint64_t, PosedFrame> tracked_;  ///< by Frame::sequence
  ScanResult result_;
};

}  // namespace

ScanResult scan_classes(const ScanJob& job, ScanObserver& observer, std::stop_token stop) {
  return ClassScan(job, observer, stop).run();
}

}  // namespace scanknit
