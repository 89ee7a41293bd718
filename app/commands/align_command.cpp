#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/commands/commands.h"
#include "app/config/quantity.h"
#include "app/scan/align_inputs.h"
#include "app/scan/align_output.h"
#include "app/scan/align_warnings.h"
#include "app/scan/run_report.h"
#include "app/scan/stage_timer.h"
#include "app/scan/texture_output.h"
#include "app/terminal/signals.h"
#include "core/files/atomic_file.h"
#include "export/mesh/write_points.h"

namespace scanknit {
namespace {

/// Two digits of the spacing of the coarsest scan: finer voxels show nothing more.
double voxel_size_for(const AlignInputs& inputs) {
  double spacing = 0;
  for (std::size_t i = 0; i < inputs.inputs.size(); ++i) {
    if (inputs.inputs[i].kind == AlignKind::kRange) spacing = std::max(spacing, inputs.models[i].spacing_m);
  }
  const double digit = std::pow(10.0, std::floor(std::log10(spacing)) - 1);
  return std::clamp(std::round(spacing / digit) * digit, 0.0002, 0.1);
}

class AlignRun {
 public:
  AlignRun(const AlignArguments& arguments, bool has_own_voxel_size, Job& job, std::stop_token stop, Console& console,
           RunReport& report)
      : arguments_(arguments),
        has_own_voxel_size_(has_own_voxel_size),
        job_(job),
        stop_(std::move(stop)),
        console_(console),
        report_(report) {}

  [[nodiscard]] Result<void> run() {
    if (auto writable = check(); !writable) return writable;
    auto loaded = load_align_inputs(arguments_.inputs, job_.config, stop_, console_, report_);
    if (stop_.stop_requested()) return Error{ErrorCode::kTooLittle, "interrupted while the scans were read: no mesh"};
    if (!loaded) return loaded.error();
    inputs_ = *std::move(loaded);
    if (auto known = find_priors(); !known) return known;
    alignment_ = timed(report_, "align", [&] {
      return align_scans(inputs_.models, priors_, [&](std::size_t done, std::size_t total) {
        console_.progress("comparing", done, total);
        return !stop_.stop_requested();
      });
    });
    if (stop_.stop_requested()) {
      return Error{ErrorCode::kTooLittle, "interrupted while pairs of scans were compared: no mesh"};
    }
    if (auto described = describe_alignment(inputs_, alignment_, picture_folder(), report_); !described)
      return described;
    tell(priors_.are_final ? given_pose_warnings(inputs_, alignment_) : prior_warnings(inputs_, priors_, alignment_));
    if (auto placed = check_placed(); !placed) return placed;
    return write();
  }

 private:
  void tell(const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) {
      console_.warn(warning);
      report_.warnings.push_back(warning);
    }
  }

  /// ... and the world that they are in.
  [[nodiscard]] Result<void> find_priors() {
    tell(unit_warnings(inputs_));
    std::vector<std::string> warnings;
    auto priors = load_align_priors(arguments_, inputs_, job_.config.acquire.limits, warnings);
    if (!priors) return priors.error();
    priors_ = *std::move(priors);
    tell(warnings);
    if (priors_.T_world_scan[0]) inputs_.world = "that of the poses that were given";
    const Eigen::Vector3d offset = move_near_origin(priors_);
    if (!offset.isZero(0)) {
      inputs_.world += fmt::format(", less {:.0f} {:.0f} {:.0f} m", offset.x(), offset.y(), offset.z());
      tell({fmt::format(
          "the given poses are far from the origin: the result is moved near it; add {:.0f} {:.0f} {:.0f} m "
          "to its positions",
          offset.x(), offset.y(), offset.z())});
    }
    const bool has_given = std::any_of(inputs_.inputs.begin(), inputs_.inputs.end(),
                                       [](const AlignInput& input) { return input.T_world_scan.has_value(); });
    if (has_given && !priors_.are_final) {
      console_.info(
          "the poses of the files are a beginning and are corrected, since --refine, --initial or --markers "
          "is given, or a scan without a pose is among them");
    }
    return {};
  }

 private:
  [[nodiscard]] Result<void> check() const {
    if (arguments_.points && !is_points_path(*arguments_.points)) {
      return Error{ErrorCode::kUsage, "--points writes .ply or .pcd", arguments_.points->string()};
    }
    if (auto writable = check_outputs(job_.outputs); !writable) return writable;
    return arguments_.points ? check_writable(*arguments_.points) : Result<void>();
  }

  /// Where the preview goes, too: with -o FILE there are no pictures.
  [[nodiscard]] std::optional<std::filesystem::path> picture_folder() const {
    if (!job_.outputs.preview) return std::nullopt;
    return job_.outputs.preview->parent_path();
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
                             "is in another one too, say where it is with --initial or --markers, or leave it out{}",
                             fmt::join(lost, ", "), inputs_.inputs[0].name, reasons)};
  }

  [[nodiscard]] Result<void> write() {
    const auto& inputs = inputs_.inputs;
    const auto fusable =
        std::count_if(inputs.begin(), inputs.end(), [](const AlignInput& input) { return input.is_fusable(); });
    auto points = arguments_.points;
    if (fusable == 0) {
      console_.warn(
          "meshes and points alone hold nothing to fuse: their points are written, each scan in its place, and no "
          "mesh");
      if (!points)
        points = job_.outputs.meshes.empty()
                     ? "points.ply"
                     : std::filesystem::path(job_.outputs.meshes[0]).replace_filename("points.ply");
    } else if (fusable < static_cast<std::ptrdiff_t>(inputs.size())) {
      console_.warn("meshes and points are brought to their place, but only range scans and recordings are fused");
    }
    if (points) {
      if (auto written = write_aligned_points(inputs_, alignment_, *points, report_); !written) return written;
    }
    if (fusable > 0) {
      const bool has_grids = std::any_of(inputs.begin(), inputs.end(),
                                         [](const AlignInput& input) { return input.kind == AlignKind::kRange; });
      if (has_grids && !has_own_voxel_size_) {
        job_.config.fusion.voxel_size_m = voxel_size_for(inputs_);
        console_.info(
            fmt::format("fusion.voxel_size: {}, the spacing of the points; --set fusion.voxel_size=... for another",
                        format_length(job_.config.fusion.voxel_size_m)));
        report_.config_json = begin_report(job_).config_json;
      }
      return fuse_aligned(inputs_, alignment_, job_, stop_, console_, report_);
    }
    job_.outputs.meshes.clear();
    return {};
  }

  const AlignArguments& arguments_;
  const bool has_own_voxel_size_;
  Job& job_;
  std::stop_token stop_;
  Console& console_;
  RunReport& report_;
  AlignInputs inputs_;
  AlignPriors priors_;
  Alignment alignment_;
};

}  // namespace

int align_command(const AlignArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // before any other thread
  const auto begin = std::chrono::steady_clock::now();
  auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  if (const auto off = refuse_texture(loaded->config, "align"); !off) return fail(off.error(), common);
  auto outputs = plan_outputs(arguments.outputs, loaded->config.output);
  if (!outputs) return fail(outputs.error(), common);
  Job job{arguments.inputs.front(), std::move(loaded->config), *outputs, Pace::kFast};
  RunReport report = begin_report(job);
  Console console(common.verbosity);
  warn_of_unused_options(job, console, report);
  AlignRun align(arguments, loaded->gives("fusion.voxel_size"), job, stop_on_signal.token(), console, report);
  const Result<void> result = align.run();
  close_report(report, result, stop_on_signal.token().stop_requested(), begin);
  return conclude(report, result, job, common);
}

}  // namespace scanknit
