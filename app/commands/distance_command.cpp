#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/measure/compare_meshes_command.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/up_rotation.h"
#include "export/mesh/write_mesh.h"
#include "synth/surface_error.h"
#include "synth/truth_files.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

Json stats_json(const DistanceStats& stats) {
  return {{"count", stats.count},
          {"mean_m", stats.mean_m},
          {"rms_m", stats.rms_m},
          {"median_m", stats.median_m},
          {"p95_m", stats.p95_m},
          {"max_m", stats.max_m},
          {"share_within_1mm", stats.share_within_1mm},
          {"share_within_5mm", stats.share_within_5mm}};
}

bool is_seen(const SurfaceError& error) {
  return error.completeness.count > 0;
}

/// Converts a mesh from the axes and units of GLB and STL files (export/mesh/write_mesh.h) to the recording's world, in
/// which the truth is given.
void to_recording_world(Mesh& mesh, const std::filesystem::path& file) {
  const std::string format = file.extension().string();
  const bool is_stl = format == ".stl";
  if (!is_stl && format != ".glb") return;
  const Eigen::Matrix3f turn = up_rotation(is_stl ? UpAxis::kZ : UpAxis::kY, UpAxis::kMinusY);
  const float scale = is_stl ? 0.001f : 1.0f;
  for (Eigen::Vector3f& p : mesh.positions_m) p = scale * (turn * p);
}

Json error_json(const SurfaceError& error) {
  return {{"vertices", stats_json(error.vertices)},
          {"area", stats_json(error.area)},
          {"completeness", is_seen(error) ? stats_json(error.completeness) : Json()},
          {"share_complete", is_seen(error) ? Json(error.share_complete) : Json()},
          {"threshold_m", error.threshold_m}};
}

std::string stats_line(const char* name, const DistanceStats& stats) {
  constexpr double kMmPerM = 1000;
  return fmt::format("{:13} mean {:.3f} mm, rms {:.3f}, median {:.3f}, 95 % {:.3f}, max {:.3f}; {:.1f} % within 1 mm\n",
                     name, stats.mean_m * kMmPerM, stats.rms_m * kMmPerM, stats.median_m * kMmPerM,
                     stats.p95_m * kMmPerM, stats.max_m * kMmPerM, stats.share_within_1mm * 100);
}

std::string error_lines(const SurfaceError& error) {
  const std::string accuracy = stats_line("Vertices", error.vertices) + stats_line("Area", error.area);
  if (!is_seen(error)) return accuracy + "Completeness  unknown: no point of the surface was seen by enough frames\n";
  return accuracy + stats_line("Completeness", error.completeness) +
         fmt::format("{:.2f} % of the visible surface is within {:.0f} mm of the mesh\n", error.share_complete * 100,
                     error.threshold_m * 1000);
}

/// Moves a mesh from the world of a run's trajectory to that of the truth: first by one frame's poses, then by
/// registering it with the true surface. Errors: kInput.
Result<void> to_true_world(Mesh& mesh, const std::filesystem::path& trajectory, const std::filesystem::path& folder) {
  const auto text = read_text_file(trajectory, Limits{}.max_text_bytes);
  if (!text) return text.error();
  const auto truth = read_truth(folder);
  if (!truth) return truth.error();
  const auto true_poses = read_true_poses(folder);
  if (!true_poses) return true_poses.error();
  const auto bad = [&](const char* what) { return Error{ErrorCode::kInput, what, trajectory.string()}; };
  std::istringstream lines(*text);
  double frame = 0;
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
  if (!(lines >> frame >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w()) || q.norm() < 0.5) {
    return bad("not a trajectory in TUM format");
  }
  if (!(frame >= 0 && frame < static_cast<double>(true_poses->size())))
    return bad("its first frame is not in the truth");
  Pose T_world_camera = Pose::Identity();
  T_world_camera.linear() = q.normalized().toRotationMatrix();
  T_world_camera.translation() = t;
  const Pose start = (*true_poses)[static_cast<std::size_t>(frame)] * T_world_camera.inverse();
  const Eigen::Isometry3f T_truth_mesh = fit_to_surface(mesh, *truth->scene, start).cast<float>();
  for (Eigen::Vector3f& p : mesh.positions_m) p = T_truth_mesh * p;
  return {};
}

}  // namespace

int distance_command(const DistanceArguments& arguments, const CommonArguments& common) {
  const auto& [mesh_file, truth, trajectory, comparison] = arguments;
  std::error_code ignored;
  if (is_mesh_path(truth) && !std::filesystem::is_directory(truth, ignored)) {
    return compare_meshes_command(arguments, common);
  }
  if (std::filesystem::is_regular_file(truth, ignored)) {
    return fail({ErrorCode::kInput,
                 "no kind of mesh that is read; expected .stl, .ply, .obj, .glb or .step, or the "
                 "folder of a synthetic recording",
                 truth.string()},
                common);
  }
  if (!comparison.is_default()) {
    return fail(
        {ErrorCode::kUsage,
         fmt::format(
             "{}: alignment, units, tolerance and -o need a mesh (.stl, .ply, .obj, .glb, .step) as the reference",
             truth.string())},
        common);
  }
  auto mesh = read_mesh(mesh_file);
  if (!mesh) return fail(mesh.error(), common);
  to_recording_world(*mesh, mesh_file);
  if (trajectory) {
    if (auto moved = to_true_world(*mesh, *trajectory, truth); !moved) return fail(moved.error(), common);
  }
  const auto error = measure_surface(*mesh, truth);
  if (!error) return fail(error.error(), common);
  return print_result(common.is_json ? error_json(*error).dump(2) + "\n" : error_lines(*error), common);
}

}  // namespace scanknit
