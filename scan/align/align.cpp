#include "scan/align/align.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/files/quantity.h"
#include "export/mesh/write_points.h"
#include "scan/align/align_output.h"
#include "scan/align/align_warnings.h"
#include "scan/checks/settings_check.h"
#include "scan/two_digits.h"

namespace scanknit {
namespace {

/// The point spacing of the coarsest scan, rounded to two digits: finer voxels show no more detail.
double voxel_size_for(const AlignInputs& inputs) {
  double spacing = 0;
  for (std::size_t i = 0; i < inputs.inputs.size(); ++i) {
    if (inputs.inputs[i].kind == AlignKind::kRange) spacing = std::max(spacing, inputs.models[i].spacing_m);
  }
  return std::clamp(two_digits(spacing), 0.0002, 0.1);
}

class AlignRun {
 public:
  AlignRun(const ScanJob& job, const AlignRequest& request, ScanObserver& observer, const std::stop_token& stop)
      : job_(job), request_(request), session_(observer, stop) {}

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = align();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

 private:
  [[nodiscard]] Result<void> align() {
    warn_of_settings(job_, session_);
    if (auto writable = check(); !writable) return writable;
    inputs_ = load_align_inputs(request_.inputs, job_.config, session_);
    result_.frames = inputs_.frames;
    if (session_.is_stopped()) return stopped_while("the scans were read");
    if (!inputs_.outcome) return inputs_.outcome;
    if (auto known = find_priors(); !known) return known;
    auto compared = session_.timed("align", [&] { return compare(); });
    if (!compared) return compared.error();
    alignment_ = *std::move(compared);
    if (session_.is_stopped()) return stopped_while("pairs of scans were compared");
    DescribedAlignment described = describe_alignment(aligned(), picture_folder(), session_);
    result_.alignment = std::move(described.result);
    if (!described.outcome) return described.outcome;
    warn(priors_.are_final ? given_pose_warnings(inputs_, alignment_) : prior_warnings(inputs_, priors_, alignment_));
    if (auto placed = check_placed(); !placed) return placed;
    return write();
  }

  [[nodiscard]] static Error stopped_while(const char* what) {
    return {ErrorCode::kTooLittle, fmt::format("interrupted while {}: no mesh", what)};
  }

  [[nodiscard]] AlignedScans aligned() const { return {inputs_, alignment_}; }

  void warn(const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) session_.warn(WarningCode::kAlignment, warning);
  }

  [[nodiscard]] Result<void> check() const {
    if (request_.points && !is_points_path(*request_.points)) {
      return Error{ErrorCode::kUsage, "points are written as .ply or .pcd", request_.points->string()};
    }
    if (auto writable = check_files(job_); !writable) return writable;
    return request_.points ? check_writable(*request_.points) : Result<void>();
  }

  /// Finds the poses that are known before registration, and names the world that they are in.
  [[nodiscard]] Result<void> find_priors() {
    warn(unit_warnings(inputs_));
    auto loaded = load_align_priors(request_.known, inputs_, job_.config.acquire.limits);
    if (!loaded) return loaded.error();
    priors_ = std::move(loaded->priors);
    warn(loaded->warnings);
    if (priors_.T_world_scan[0]) inputs_.world = "that of the poses that were given";
    move_near_origin();
    const bool has_given = std::any_of(inputs_.inputs.begin(), inputs_.inputs.end(),
                                       [](const AlignInput& input) { return input.T_world_scan.has_value(); });
    if (has_given && !priors_.are_final) {
      session_.info(fmt::format("the poses in the files are only a start: {}", why_poses_are_a_start()));
    }
    return {};
  }

  [[nodiscard]] const char* why_poses_are_a_start() const {
    if (request_.known.wants_refinement) return "refining was asked for";
    if (request_.known.initial) return "initial poses are given";
    if (request_.known.markers) return "markers are given";
    return "a scan has no pose";
  }

  /// Moves poses that are far from the origin near it, because positions of the mesh are 32-bit floats.
  void move_near_origin() {
    const Eigen::Vector3d offset = offset_from_origin(priors_);
    if (offset.isZero(0)) return;
    for (auto& pose : priors_.T_world_scan) {
      if (pose) pose->translation() -= offset;
    }
    inputs_.world += fmt::format(", less {:.0f} {:.0f} {:.0f} m", offset.x(), offset.y(), offset.z());
    warn(
        {fmt::format("the given poses are far from the origin: the result is moved near it; add {:.0f} {:.0f} "
                     "{:.0f} m to its positions",
                     offset.x(), offset.y(), offset.z())});
  }

  [[nodiscard]] Result<Alignment> compare() {
    return align_scans(inputs_.models, priors_, [&](std::size_t done, std::size_t total) {
      session_.progress("comparing", done, total);
      return !session_.is_stopped();
    });
  }

  /// The folder of the preview; nothing when the output is one file, because then no pictures are written.
  [[nodiscard]] std::optional<std::filesystem::path> picture_folder() const {
    if (!job_.files.preview) return std::nullopt;
    return job_.files.preview->parent_path();
  }

  [[nodiscard]] Result<void> check_placed() const {
    std::vector<std::string> lost;
    for (std::size_t i = 0; i < inputs_.inputs.size(); ++i) {
      if (!alignment_.is_placed[i]) lost.push_back(fmt::format("{} ({})", i + 1, inputs_.inputs[i].name));
    }
    if (lost.empty()) return {};
    std::string reasons;
    for (const AlignedPair& pair : alignment_.pairs) {
      if (alignment_.is_placed[pair.from] == alignment_.is_placed[pair.to]) continue;
      reasons += fmt::format("\n  {} and {}: {}", pair.from + 1, pair.to + 1, pair.judgement.reason);
    }
    return Error{ErrorCode::kTooLittle,
                 fmt::format("no place was found for {} beside scan 1 ({}). Scan so that at least a third of each scan "
                             "is in another one too, say where it is by initial poses or markers, or leave it out{}",
                             fmt::join(lost, ", "), inputs_.inputs[0].name, reasons)};
  }

  [[nodiscard]] Result<void> write() {
    const auto fusable = std::count_if(inputs_.inputs.begin(), inputs_.inputs.end(),
                                       [](const AlignInput& input) { return input.is_fusable(); });
    auto points = request_.points;
    if (fusable == 0) {
      session_.warn(
          WarningCode::kPointsOnly,
          "meshes and point clouds cannot be fused, and no other scan was given: no mesh is made; the points of "
          "each scan are written, in its place");
      if (!points) points = default_points();
    } else if (fusable < static_cast<std::ptrdiff_t>(inputs_.inputs.size())) {
      session_.warn(WarningCode::kPointsOnly,
                    "meshes and points are brought to their place, but only range scans and recordings are fused");
    }
    if (points) {
      result_.files["points"] = points->string();
      if (auto written = write_aligned_points(aligned(), *points, session_); !written) return written;
    }
    if (fusable == 0) return {};
    choose_voxel_size();
    return fuse();
  }

  [[nodiscard]] Result<void> fuse() {
    FusedScans fused = AlignedFusion(aligned(), job_, session_).run();
    result_.frames.fused += fused.frames;
    result_.volume = std::move(fused.volume);
    result_.mesh = std::move(fused.mesh);
    result_.files.merge(fused.files);
    return fused.outcome;
  }

  [[nodiscard]] std::filesystem::path default_points() const {
    const auto& meshes = job_.files.meshes;
    return meshes.empty() ? "points.ply" : std::filesystem::path(meshes[0]).replace_filename("points.ply");
  }

  void choose_voxel_size() {
    const bool has_grids = std::any_of(inputs_.inputs.begin(), inputs_.inputs.end(),
                                       [](const AlignInput& input) { return input.kind == AlignKind::kRange; });
    if (!has_grids || request_.has_voxel_size) return;
    job_.config.fusion.voxel_size_m = voxel_size_for(inputs_);
    session_.info(fmt::format("fusion.voxel_size: {}, the spacing of the points; set fusion.voxel_size for another",
                              format_length(job_.config.fusion.voxel_size_m)));
  }

  ScanJob job_;
  const AlignRequest& request_;
  ScanSession session_;
  AlignInputs inputs_;
  AlignPriors priors_;
  Alignment alignment_;
  ScanResult result_;
};

}  // namespace

ScanResult align_and_mesh(const ScanJob& job, const AlignRequest& request, ScanObserver& observer,
                          std::stop_token stop) {
  return AlignRun(job, request, observer, stop).run();
}

}  // namespace scanknit
