#include "scan/align/align_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/files/atomic_file.h"
#include "export/mesh/write_points.h"
#include "export/picture/preview.h"
#include "export/trajectory.h"
#include "fusion/range/range_integrate.h"
#include "scan/checks/memory_share.h"
#include "scan/frames/fuse_again.h"
#include "scan/mesh/finish_surface.h"
#include "scan/mesh/write_surface.h"
#include "scan/reconstruction.h"

namespace scanknit {
namespace {

constexpr Rgb8 kOrange{230, 120, 30};
constexpr Rgb8 kBlue{40, 110, 210};
constexpr std::size_t kMostDots = 60'000;  // for each scan in a picture

/// Adds a small triangle at each point, perpendicular to its normal.
void add_dots(const ScanModel& model, const Pose& T, double size_m, Rgb8 colour, Mesh& picture) {
  const OrientedPoints dots = thin_out(model.all, size_m);
  const std::size_t every = std::max<std::size_t>(1, dots.size() / kMostDots);
  for (std::size_t i = 0; i < dots.size(); i += every) {
    const Eigen::Vector3d p = T * dots.points_m[i].cast<double>();
    const Eigen::Vector3d n = T.linear() * dots.normals[i].cast<double>();
    const Eigen::Vector3d u = n.unitOrthogonal() * size_m;
    const Eigen::Vector3d v = n.cross(u);
    const auto first = static_cast<std::uint32_t>(picture.positions_m.size());
    for (const Eigen::Vector3d& corner :
         {Eigen::Vector3d(u), Eigen::Vector3d(-0.5 * u + 0.87 * v), Eigen::Vector3d(-0.5 * u - 0.87 * v)}) {
      picture.positions_m.push_back((p + corner).cast<float>());
      picture.normals.push_back(n.cast<float>());
      picture.colours.push_back(colour);
    }
    picture.triangles.push_back({first, first + 1, first + 2});
  }
}

/// Draws the picture in the first scan's frame; up is as that scan's file says.
Result<void> write_picture(const AlignInputs& inputs, const Alignment& alignment, const AlignedPair& pair,
                           const std::filesystem::path& path) {
  const bool is_placed = alignment.is_placed[pair.from] && alignment.is_placed[pair.to];
  const Pose& T_world_from = alignment.T_world_scan[pair.from];
  const Pose T_world_to = is_placed ? alignment.T_world_scan[pair.to] : Pose(T_world_from * pair.T_from_to);
  Mesh picture;
  add_dots(inputs.models[pair.from], T_world_from, alignment.scale.fine_m, kOrange, picture);
  add_dots(inputs.models[pair.to], T_world_to, alignment.scale.fine_m, kBlue, picture);
  return write_png(render_preview(picture, inputs.inputs[pair.from].world_up), path);
}

AlignmentResult::Pair described_pair(const AlignedPair& pair) {
  AlignmentResult::Pair line{.from = pair.from + 1,
                             .to = pair.to + 1,
                             .verdict = pair.judgement.verdict,
                             .reason = pair.judgement.reason,
                             .start = pair.start,
                             .residual_m = pair.measure.residual_m,
                             .overlap = pair.measure.overlap,
                             .off_m = pair.off_m,
                             .least_strength = pair.measure.least_strength,
                             .contradicted = {},
                             .missing = {},
                             .picture = {}};
  if (pair.measure.is_seen) {
    line.contradicted = pair.measure.contradicted;
    line.missing = pair.measure.missing;
  }
  return line;
}

}  // namespace

DescribedAlignment describe_alignment(const AlignedScans& scans,
                                      const std::optional<std::filesystem::path>& picture_folder,
                                      ScanSession& session) {
  const auto& [inputs, alignment] = scans;
  DescribedAlignment described;
  described.result.spacing_m = alignment.scale.fine_m;
  for (std::size_t i = 0; i < inputs.inputs.size(); ++i) {
    described.result.scans.push_back({inputs.inputs[i].name, inputs.inputs[i].kind, inputs.models[i].all.size(),
                                      alignment.is_placed[i], alignment.T_world_scan[i]});
  }
  for (const AlignedPair& pair : alignment.pairs) {
    AlignmentResult::Pair line = described_pair(pair);
    if (picture_folder) {
      const auto path = *picture_folder / fmt::format("pair_{}_{}.png", line.from, line.to);
      line.picture = path.string();
      described.outcome =
          session.timed("export", [&] { return write_picture(scans.inputs, scans.alignment, pair, path); });
      if (!described.outcome) break;
    }
    described.result.pairs.push_back(std::move(line));
  }
  return described;
}

AlignedFusion::AlignedFusion(const AlignedScans& scans, const ScanJob& job, ScanSession& session)
    : inputs_(scans.inputs), alignment_(scans.alignment), job_(job), session_(session) {}

FusedScans AlignedFusion::run() {
  made_.outcome = fuse_and_write();
  return std::move(made_);
}

Result<void> AlignedFusion::fuse_and_write() {
  if (auto written = write_poses(); !written) return written;
  auto volume = TsdfVolume::create(volume_config(job_.config.fusion));
  if (!volume) return volume.error();
  for (std::size_t i = 0; i < inputs_.inputs.size(); ++i) {
    if (!inputs_.inputs[i].is_fusable() || session_.is_stopped()) continue;
    session_.progress("fusing", i + 1, inputs_.inputs.size());
    const auto fused = fuse(i, *volume);
    if (!fused) return fused.error();
    made_.frames += *fused;
  }
  if (session_.is_stopped()) {
    if (made_.frames == 0) return Error{ErrorCode::kTooLittle, "interrupted before anything was fused: no mesh"};
    session_.warn(WarningCode::kAlignInterrupted, "interrupted: the mesh holds only what was fused until then");
  }
  if (volume->is_budget_reached) {
    session_.warn(WarningCode::kBudgetReached, "the volume has reached fusion.memory_budget: the mesh is incomplete");
  }
  made_.volume = described(*volume);
  if (auto saved = save(*volume); !saved) return saved;
  return mesh(*volume);
}

/// Returns how many frames were fused; a range scan counts as one.
Result<std::size_t> AlignedFusion::fuse(std::size_t scan, TsdfVolume& volume) {
  const AlignInput& input = inputs_.inputs[scan];
  const Pose& T_world_scan = alignment_.T_world_scan[scan];
  if (input.kind == AlignKind::kRange) {
    const RangeView& view = inputs_.models[scan].sights[0].view;
    const auto fused =
        session_.timed("integrate", [&] { return integrate(view, input.noise_m, T_world_scan, volume); });
    return fused ? Result<std::size_t>(1) : fused.error();
  }
  const auto source = open_recording(input.path, input.config.acquire);
  if (!source) return source.error();
  Trajectory trajectory = input.trajectory;
  for (PosedFrame& frame : trajectory) frame.T_world_camera = T_world_scan * frame.T_world_camera;
  return session_.timed("integrate",
                        [&] { return fuse_again(**source, {trajectory}, input.config, volume, session_); });
}

Result<void> AlignedFusion::write_poses() {
  if (!job_.files.trajectory) return {};
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < alignment_.T_world_scan.size(); ++i) {
    poses.push_back({static_cast<double>(i + 1), alignment_.T_world_scan[i]});
  }
  made_.files["trajectory"] = job_.files.trajectory->string();
  const std::string text =
      trajectory_text(*job_.files.trajectory, poses, "scan tx ty tz qx qy qz qw; the world is " + inputs_.world);
  return session_.timed("write", [&] { return write_file_atomically(*job_.files.trajectory, text); });
}

Result<void> AlignedFusion::save(const TsdfVolume& volume) {
  if (!job_.files.volume) return {};
  made_.files["volume"] = job_.files.volume->string();
  return session_.timed("write", [&] { return volume.save(*job_.files.volume); });
}

Result<void> AlignedFusion::mesh(const TsdfVolume& volume) {
  const bool has_colours = std::any_of(inputs_.inputs.begin(), inputs_.inputs.end(), [](const AlignInput& input) {
    return input.kind == AlignKind::kRecording || !input.colours.empty();
  });
  const UpAxis world_up = inputs_.inputs[0].world_up;
  made_.mesh.isovalue = job_.config.extract.isovalue;
  const FieldView view = has_colours ? volume.field_view() : volume.field_view().without_colours();
  const FinishedSurface finished = finished_surface(view, {job_.config, world_up, 1, session_.stop()}, session_);
  add_to(made_.mesh, finished);
  if (!finished.outcome) return finished.outcome;
  WrittenSurface written = write_surface(finished.surface.mesh, {world_up, std::nullopt, std::nullopt}, job_, session_);
  const Result<void> outcome = written.outcome;
  add_to(made_.mesh, std::move(written));
  return outcome;
}

Result<void> write_aligned_points(const AlignedScans& scans, const std::filesystem::path& path, ScanSession& session) {
  const auto& [inputs, alignment] = scans;
  const bool has_colours = std::none_of(inputs.inputs.begin(), inputs.inputs.end(),
                                        [](const AlignInput& input) { return input.colours.empty(); });
  Mesh all;
  for (std::size_t i = 0; i < inputs.models.size(); ++i) {
    const OrientedPoints& points = inputs.models[i].all;
    const Pose& T = alignment.T_world_scan[i];
    for (std::size_t k = 0; k < points.size(); ++k) {
      all.positions_m.push_back((T * points.points_m[k].cast<double>()).cast<float>());
      all.normals.push_back((T.linear() * points.normals[k].cast<double>()).cast<float>());
      if (has_colours) all.colours.push_back(inputs.inputs[i].colours[k]);
    }
  }
  return session.timed("write", [&] { return write_points(all, path); });
}

}  // namespace scanknit
