#include "scan/bricks/scan_in_bricks.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "core/files/atomic_file.h"
#include "export/trajectory.h"
#include "fusion/bricks/brick_parts.h"
#include "fusion/bricks/brick_plan.h"
#include "fusion/bricks/brick_volume.h"
#include "fusion/integrate/integrate_part.h"
#include "fusion/volume/block_size.h"
#include "fusion/volume/volume_memory.h"
#include "scan/bricks/layered_bricks.h"
#include "scan/bricks/part_folder.h"
#include "scan/frames/depth_samples.h"
#include "scan/frames/frame_intake.h"
#include "scan/frames/recorded_frames.h"
#include "scan/mesh/mesh_scan.h"
#include "scan/mesh/vertex_uncertainty.h"
#include "scan/mesh/write_texture.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

bool has_frame(const std::vector<FrameRun>& runs, std::uint32_t number) {
  const auto after =
      std::partition_point(runs.begin(), runs.end(), [&](const FrameRun& run) { return run.last < number; });
  return after != runs.end() && after->first <= number;
}

/// A file whose folder has room for what the scan writes.
fs::path largest_file(const ScanFiles& files) {
  const std::vector<fs::path> paths = all_paths(files);
  return paths.empty() ? fs::temp_directory_path() / "scan" : paths.front();
}

class BrickScan {
 public:
  BrickScan(const ScanJob& job, const PassInput& input, ScanSession& session)
      : job_(job),
        input_(input),
        session_(session),
        keeps_samples_(job.measures_fit || job.config.finish.drops_crumbs || job.config.output.uncertainty),
        plan_(job.config.fusion),
        bricks_(job.config.fusion) {}

  [[nodiscard]] ScanResult run() {
    result_.outcome = scan();
    return std::move(result_);
  }

 private:
  [[nodiscard]] Result<void> scan() {
    if (auto planned = plan(); !planned) return planned;
    if (auto written = write_trajectory(); !written) return written;
    const auto folder = PartFolder::create(largest_file(job_.files));
    if (!folder) return folder.error();
    if (auto fused = fuse_all(folder->path()); !fused) return fused;
    return mesh();
  }

  [[nodiscard]] Result<void> plan() {
    if (auto sound = TsdfVolume::create(job_.config.fusion); !sound) return sound.error();
    FrameIntake intake(input_.source, job_.config.acquire, session_, {input_.stop, input_.counted});
    while (!intake.is_over()) {
      auto frame = intake.next();
      if (!frame) continue;
      const auto added = plan(*frame);
      if (!added) return added.error();
      intake.count(*frame, *added);
      session_.progress("planning bricks", intake.counts().read, intake.info().frames);
    }
    result_.frames = intake.counts();
    if (input_.stop.stop_requested()) return Error{ErrorCode::kInput, "interrupted before the first brick was fused"};
    return intake.conclude();
  }

  [[nodiscard]] Result<Reconstruction::Added> plan(Frame& frame) {
    if (auto filtered = filter(frame); !filtered) return filtered.error();
    const auto planned = session_.timed("plan", [&] { return plan_.add(frame, *frame.T_world_camera); });
    if (!planned && planned.error().code == ErrorCode::kInput) return Reconstruction::Added{{}, planned.error()};
    if (!planned) return planned.error();
    result_.trajectory.push_back({frame.sequence, stamp_of(frame), *frame.T_world_camera});
    if (keeps_samples_) samples_.add(frame);
    return Reconstruction::Added{frame.T_world_camera};
  }

  [[nodiscard]] Result<void> filter(Frame& frame) {
    return session_.timed("filter", [&] { return filter_frame(frame, job_.config.acquire, job_.config.fusion.noise); });
  }

  [[nodiscard]] Result<void> write_trajectory() {
    if (!job_.files.trajectory) return {};
    result_.files["trajectory"] = job_.files.trajectory->string();
    const std::string text = trajectory_text(*job_.files.trajectory, stamped_poses(result_.trajectory));
    return session_.timed("write", [&] { return write_file_atomically(*job_.files.trajectory, text); });
  }

  [[nodiscard]] Result<std::vector<BrickPart>> parts() const {
    const FusionConfig& fusion = job_.config.fusion;
    const std::size_t max_bytes = fusion.memory_budget_mib << 20;
    if (fusion.bricks == BrickSize::kAuto) return parts_within(plan_, max_bytes);
    return parts_of_bricks(plan_, static_cast<int>(fusion.bricks), max_bytes);
  }

  [[nodiscard]] Result<void> fuse_all(const fs::path& folder) {
    const auto all = parts();
    if (!all) return all.error();
    std::size_t readings = 0;
    for (const BrickPart& part : *all) readings += count_frames(part.frames);
    session_.info(fmt::format("the volume is fused in {} parts; a frame is fused into {:.1f} of them on average",
                              all->size(), static_cast<double>(readings) / static_cast<double>(plan_.frames())));
    std::size_t done = 0;
    for (const BrickPart& part : *all) {
      const auto is_whole = fuse(part, folder / fmt::format("{}.brick", done));
      if (!is_whole) return is_whole.error();
      if (!*is_whole) break;
      session_.progress("fusing bricks", ++done, all->size());
    }
    describe_volume();
    if (done == all->size()) return {};
    if (done == 0) return Error{ErrorCode::kInput, "interrupted before the first brick was fused"};
    session_.warn(WarningCode::kStoppedEarly,
                  fmt::format("interrupted: the mesh holds {} of the {} parts of the volume", done, all->size()));
    return {};
  }

  /// False when a stop was requested, and the part is not whole.
  [[nodiscard]] Result<bool> fuse(const BrickPart& part, const fs::path& path) {
    auto volume = TsdfVolume::create(job_.config.fusion);
    if (!volume) return volume.error();
    const auto fused = fuse_frames(part, *volume);
    if (!fused || !*fused) return fused;
    if (volume->is_budget_reached) return Error{ErrorCode::kInternal, "a part of the volume is larger than planned"};
    count(*volume);
    const std::uint64_t scan = plan_.checksum();
    auto written = session_.timed("write_bricks", [&] { return write_brick_file(*volume, scan, path); });
    if (written) written = bricks_.add(path, scan);
    return written ? Result<bool>(true) : written.error();
  }

  [[nodiscard]] Result<bool> fuse_frames(const BrickPart& part, TsdfVolume& volume) {
    const SequenceRanges only = sequences_of(part.frames);
    const auto source = open_frames(job_, &only);
    if (!source) return source.error();
    std::size_t left = count_frames(part.frames);
    const auto read = for_each_frame(**source, session_.stop(), [&](Frame& frame) -> Result<Reading> {
      const auto number = number_of(frame);
      if (!number || !has_frame(part.frames, *number)) return Reading::kContinue;
      if (auto filtered = filter(frame); !filtered) return filtered.error();
      const Pose& T_world_camera = result_.trajectory[*number - 1].T_world_camera;
      const auto fused = session_.timed(
          "integrate", [&] { return integrate_part(frame, T_world_camera, *number, part.regions, volume); });
      if (!fused) return fused.error();
      return --left > 0 ? Reading::kContinue : Reading::kStop;
    });
    if (!read) return read.error();
    if (left == 0) return true;
    if (session_.is_stopped()) return false;
    return Error{ErrorCode::kInput, "has lost frames while it was scanned; scan it again", job_.input.string()};
  }

  [[nodiscard]] SequenceRanges sequences_of(const std::vector<FrameRun>& runs) const {
    SequenceRanges sequences;
    for (const FrameRun& run : runs) {
      sequences.add(result_.trajectory[run.first - 1].sequence);
      sequences.add(result_.trajectory[run.last - 1].sequence);
      sequences.cut();
    }
    return sequences;
  }

  /// The frame's number in the plan.
  [[nodiscard]] std::optional<std::uint32_t> number_of(const Frame& frame) const {
    const auto found =
        std::lower_bound(result_.trajectory.begin(), result_.trajectory.end(), frame.sequence,
                         [](const PosedFrame& posed, std::uint64_t sequence) { return posed.sequence < sequence; });
    if (found == result_.trajectory.end() || found->sequence != frame.sequence) return std::nullopt;
    return static_cast<std::uint32_t>(found - result_.trajectory.begin()) + 1;
  }

  void count(const TsdfVolume& volume) {
    result_.volume.active_voxels += volume.active_voxels();
    result_.volume.blocks += volume.blocks();
    for (const VolumeBlock& block : volume.index().blocks()) {
      memory_.add(block.origin);
      if (has_own_colours(*block.colour)) memory_.add_colours();
    }
  }

  /// As if the volume were in memory as a whole.
  void describe_volume() {
    constexpr double kBytesPerMebibyte = 1024.0 * 1024.0;
    result_.volume.memory_mib = static_cast<double>(memory_.bytes()) / kBytesPerMebibyte;
    result_.volume.voxel_size_m = job_.config.fusion.voxel_size_m;
  }

  [[nodiscard]] Result<void> mesh() {
    constexpr std::size_t kBytesPerBlock = 8192;  // with what extraction keeps of it
    const std::size_t blocks_at_once = (job_.config.fusion.memory_budget_mib << 20) / kBytesPerBlock;
    LayeredBricks layers(bricks_);
    auto surface =
        session_.timed("extract", [&] { return extract_surface(layers, job_.config.extract, blocks_at_once); });
    if (!surface) return surface.error();
    const CropBox no_crop;
    const UpAxis world_up = input_.source.info().world_up;
    const MeshRequest request{job_, world_up, no_crop, EmptyCrop::kIgnored, input_.stop};
    ScannedFrames frames{result_.trajectory, samples_.posed(result_.trajectory)};
    FinishedSurface finished =
        finished_mesh(*std::move(surface), {job_.config, world_up, 1, input_.stop, frames.samples}, session_);
    if (auto estimated = estimate_uncertainty(layers, frames.samples, finished); !estimated) return estimated;
    MeshedScan meshed = mesh_finished(std::move(finished), std::move(frames), request, session_);
    result_.mesh = std::move(meshed.result);
    for (const auto& [kind, path] : result_.mesh.files) result_.files[kind] = path;
    if (!meshed.outcome) return meshed.outcome;
    TexturedMesh textured = write_textured(meshed.written, job_, input_.archive, session_);
    result_.texture = std::move(textured.texture);
    return textured.outcome;
  }

  /// Reads the bricks again, a layer at a time with its neighbours, which have the other corners of its last
  /// cells, and the rest of patches.
  [[nodiscard]] Result<void> estimate_uncertainty(LayeredBricks& layers, std::span<const PosedDepth> samples,
                                                  FinishedSurface& finished) {
    if (!job_.config.output.uncertainty || !finished.outcome) return {};
    const StageTimer timer(session_.times()["finish"]);
    const Mesh& mesh = finished.surface.mesh;
    std::vector<float> weights(mesh.positions_m.size(), 0.0f);
    const FusionConfig& fusion = job_.config.fusion;
    NoiseShare share(samples, fusion.noise);
    for (const BlockLayer& layer : layers.layers()) {
      const auto view = layers.read(layer.x - kBlockEdgeVoxels, layer.x + 3 * kBlockEdgeVoxels);
      if (!view) return view.error();
      raise_weights(mesh, finished.T_mesh_world().inverse(), *view, weights);
      share.add(*view, layer.x, layer.x + kBlockEdgeVoxels);
    }
    finished.uncertainty_m = uncertainties_m(weights, {fusion.noise.floor_m * share.value(), fusion.voxel_size_m});
    return {};
  }

  const ScanJob& job_;
  const PassInput& input_;
  ScanSession& session_;
  bool keeps_samples_;
  BrickPlan plan_;
  DepthSamples samples_;
  BrickVolume bricks_;
  VolumeMemory memory_;  ///< of all parts together
  ScanResult result_;
};

}  // namespace

ScanResult scan_in_bricks(const ScanJob& job, const PassInput& input, ScanSession& session) {
  return BrickScan(job, input, session).run();
}

}  // namespace scanknit
