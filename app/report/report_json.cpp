#include "app/report/report_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "acquire/live/loss_names.h"
#include "app/config/config_print.h"
#include "core/version.h"
#include "export/measure/mesh_stats.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxDropMessages = 100;
/// The stages that are always in the report, in the order in which a frame passes them.
constexpr std::array kStages = {"read",      "acquire", "filter", "track", "raycast",
                                "integrate", "extract", "export", "write"};

/// JSON has no NaN or infinity: these become 0, so that the document stays readable.
double finite(double value) {
  return std::isfinite(value) ? value : 0.0;
}

template <typename Map>
Json object_of(const Map& map) {
  Json json = Json::object();
  for (const auto& [key, value] : map) json[key] = value;
  return json;
}

Json frames_json(const FrameCounts& frames) {
  Json json;
  json["read"] = frames.read;
  json["fused"] = frames.fused;
  json["dropped"] = frames.dropped;
  json["lost"] = frames.lost;
  json["dropped_by_reason"] = object_of(frames.dropped_by_reason);
  json["drop_messages"] = Json::array();
  for (std::size_t i = 0; i < std::min(frames.drop_messages.size(), kMaxDropMessages); ++i) {
    json["drop_messages"].push_back(frames.drop_messages[i]);
  }
  return json;
}

Json loops_json(const std::optional<LoopResult>& loops) {
  if (!loops) return nullptr;
  Json json;
  json["is_corrected"] = loops->is_corrected;
  json["drift_m"] = finite(loops->drift_m);
  json["largest_correction_m"] = finite(loops->largest_correction_m);
  json["pairs"] = Json::array();
  for (const LoopResult::Pair& pair : loops->pairs) {
    json["pairs"].push_back({{"from", pair.from},
                             {"to", pair.to},
                             {"shift_m", finite(pair.shift_m)},
                             {"overlap", finite(pair.overlap)},
                             {"inlier_share", finite(pair.inlier_share)},
                             {"refused", pair.refused}});
  }
  return json;
}

Json tracking_json(const ScanResult& scan) {
  if (!scan.tracking) return nullptr;
  Json json;
  json["mode"] = scan.tracking->prior == PosePrior::kRefine ? "refine" : "track";
  for (const TrackState state : {TrackState::kOk, TrackState::kWeak, TrackState::kLost, TrackState::kRecovered}) {
    json["states"][to_string(state)] = count_of(*scan.tracking, state);
  }
  json["found_later"] = scan.tracking->found_later;
  std::map<std::string, std::size_t> found_later_by;
  for (const TrackedFrame& frame : scan.tracking->frames) {
    const bool is_found_later = frame.state == TrackState::kRecovered && frame.reason != TrackReason::kNone;
    if (is_found_later) ++found_later_by[to_string(frame.reason)];
  }
  if (!found_later_by.empty()) json["found_later_by"] = object_of(found_later_by);
  json["frames"] = Json::array();
  for (const TrackedFrame& frame : scan.tracking->frames) {
    json["frames"].push_back({{"frame", frame.sequence},
                              {"state", to_string(frame.state)},
                              {"reason", to_string(frame.reason)},
                              {"points", frame.points},
                              {"overlap", finite(frame.overlap)},
                              {"inlier_share", finite(frame.inlier_share)},
                              {"rms_sigma", finite(frame.rms_sigma)},
                              {"weak_directions", frame.weak_directions}});
  }
  json["loops"] = loops_json(scan.loops);
  return json;
}

Json pose_json(const Pose& pose) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({finite(pose(row, 0)), finite(pose(row, 1)), finite(pose(row, 2)), finite(pose(row, 3))});
  }
  return rows;
}

Json silhouettes_json(const std::optional<SilhouetteResult>& silhouettes) {
  if (!silhouettes) return nullptr;
  return {{"pictures", silhouettes->pictures},
          {"agreement", finite(silhouettes->agreement)},
          {"worst_overlap", finite(silhouettes->worst_overlap)},
          {"worst_picture", silhouettes->worst_picture}};
}

Json alignment_json(const std::optional<AlignmentResult>& aligned) {
  if (!aligned) return nullptr;
  Json json;
  json["spacing_m"] = finite(aligned->spacing_m);
  json["scans"] = Json::array();
  for (const auto& scan : aligned->scans) {
    json["scans"].push_back({{"name", scan.name},
                             {"kind", to_string(scan.kind)},
                             {"points", scan.points},
                             {"is_placed", scan.is_placed},
                             {"T_world_scan", scan.is_placed ? pose_json(scan.T_world_scan) : Json(nullptr)}});
  }
  json["pairs"] = Json::array();
  for (const auto& pair : aligned->pairs) {
    json["pairs"].push_back({{"from", pair.from},
                             {"to", pair.to},
                             {"verdict", to_string(pair.verdict)},
                             {"reason", pair.reason},
                             {"start", to_string(pair.start)},
                             {"residual_mm", finite(pair.residual_m * 1000)},
                             {"overlap", finite(pair.overlap)},
                             {"contradicted", pair.contradicted ? Json(finite(*pair.contradicted)) : Json(nullptr)},
                             {"missing", pair.missing ? Json(finite(*pair.missing)) : Json(nullptr)},
                             {"off_mm", finite(pair.off_m * 1000)},
                             {"least_strength", finite(pair.least_strength)},
                             {"picture", pair.picture.empty() ? Json(nullptr) : Json(pair.picture)}});
  }
  return json;
}

Json vector_json(const Eigen::Vector3d& v) {
  return Json::array({finite(v.x()), finite(v.y()), finite(v.z())});
}

Json turntable_json(const std::optional<TurntableResult>& turntable) {
  if (!turntable) return nullptr;
  constexpr double kDegreesPerRadian = 180 / std::numbers::pi;
  const TurntableResult& table = *turntable;
  Json json;
  json["is_refined"] = table.is_refined;
  json["reason"] = table.reason;
  json["axis"] = nullptr;
  if (table.is_refined) {
    json["axis"] = {{"direction", vector_json(table.axis_direction)}, {"point_m", vector_json(table.axis_point)}};
  }
  json["turns"] = finite(table.turns);
  json["is_closed"] = table.is_closed;
  json["prior"] = to_string(table.prior);
  json["rms_m"] = finite(table.rms_m);
  json["rms_degrees"] = finite(table.rms_rad * kDegreesPerRadian);
  const double held = table.angle_sigma_rad * kDegreesPerRadian;
  json["angle_sigma_degrees"] = std::isfinite(held) ? Json(held) : Json(nullptr);
  json["is_angle_held"] = table.is_angle_held;
  json["key_frames"] = table.key_frames;
  json["pairs"] = {{"all", table.pairs}, {"loops", table.loops}, {"across", table.across}};
  json["cut"] = {{"still_scene", table.has_still_scene},
                 {"radius_m", finite(table.radius_m)},
                 {"disc_m", table.disc_m ? Json(finite(*table.disc_m)) : Json(nullptr)},
                 {"pixels_looked_through", table.pixels_looked_through},
                 {"has_base", table.has_base}};
  json["angles"] = Json::array();
  for (const auto& [frame, angle_rad] : table.angles_rad) {
    json["angles"].push_back({{"frame", frame}, {"degrees", finite(angle_rad * kDegreesPerRadian)}});
  }
  return json;
}

Json stage_json(const StageTimes& times) {
  return Json{{"total_ms", finite(times.total_ms())},
              {"median_ms", finite(times.median_ms())},
              {"p95_ms", finite(times.p95_ms())},
              {"peak_rss_mib", finite(times.peak_rss_mib)}};
}

Json stages_json(const StageTimesByName& stages) {
  Json json;
  for (const char* name : kStages) {
    const auto found = stages.find(name);
    json[name] = stage_json(found == stages.end() ? StageTimes{} : found->second);
  }
  for (const auto& [name, times] : stages) {
    if (!json.contains(name)) json[name] = stage_json(times);
  }
  return json;
}

Json volume_json(const VolumeResult& volume) {
  Json json;
  json["active_voxels"] = volume.active_voxels;
  json["blocks"] = volume.blocks;
  json["memory_mib"] = finite(volume.memory_mib);
  json["voxel_size_m"] = finite(volume.voxel_size_m);
  json["is_budget_reached"] = volume.is_budget_reached;
  json["format"] = volume.format.empty() ? Json(nullptr) : Json(volume.format);
  const bool is_dense = volume.dims[0] > 0;
  json["dims"] = is_dense ? Json(volume.dims) : Json(nullptr);
  json["spacing_m"] = is_dense ? Json::array() : Json(nullptr);
  for (const double spacing : volume.spacing_m) {
    if (is_dense) json["spacing_m"].push_back(finite(spacing));
  }
  json["is_streamed"] = volume.is_streamed;
  return json;
}

Json mesh_json(const MeshResult& mesh) {
  if (!mesh.check) return nullptr;
  Json json = Json::parse(mesh_check_json(*mesh.check));
  if (mesh.is_checked) return json;
  for (auto& [key, value] : json.items()) {
    if (key != "vertices" && key != "triangles" && key != "bounds_m") value = nullptr;
  }
  return json;
}

Json holes_json(const std::optional<HolesResult>& holes) {
  if (!holes) return nullptr;
  Json json;
  json["count"] = holes->count;
  json["total_length_m"] = finite(holes->total_length_m);
  json["longest_m"] = Json::array();
  for (const double length_m : holes->longest_m) json["longest_m"].push_back(finite(length_m));
  return json;
}

/// Of each class of the masks what the report has of a mesh; null unless each class got one.
Json classes_json(const std::vector<ClassResult>& classes) {
  if (classes.empty()) return nullptr;
  Json json = Json::array();
  for (const ClassResult& one : classes) {
    json.push_back({{"class", one.label},
                    {"volume", volume_json(one.volume)},
                    {"mesh", mesh_json(one.mesh)},
                    {"area_m2", one.area_m2 ? Json(finite(*one.area_m2)) : Json(nullptr)},
                    {"holes", holes_json(one.mesh.holes)},
                    {"files", object_of(one.mesh.files)}});
  }
  return json;
}

Json doubled_json(const std::optional<DoubledResult>& doubled) {
  if (!doubled) return nullptr;
  return Json{{"area_m2", finite(doubled->area_m2)}, {"share", finite(doubled->share)}};
}

Json fit_json(const std::optional<FitResult>& fit) {
  if (!fit) return nullptr;
  return Json{{"frames", fit->frames},
              {"seen_share", finite(fit->seen_share)},
              {"median_m", finite(fit->median_m)},
              {"p95_m", finite(fit->p95_m)},
              {"error_map_end_m", finite(fit->error_map_end_m)},
              {"coverage_map_end", fit->coverage_map_end}};
}

const char* name_of(IsovalueSource source) {
  switch (source) {
    case IsovalueSource::kConfig: return "config";
    case IsovalueSource::kSignedDistance: return "signed_distance";
    case IsovalueSource::kOtsu: return "otsu";
  }
  return "";
}

/// Kind of cell -> count.
std::map<std::string, std::size_t> named_cases(const CaseCounts& counts) {
  std::map<std::string, std::size_t> cases;
  constexpr int kConfigurations = 15;
  for (int i = 0; i < kConfigurations; ++i) {
    cases[fmt::format("configuration_{:02}", i)] = counts.of_configuration(i);
  }
  cases["ambiguous_faces_joined"] = counts.ambiguous_faces_joined;
  cases["ambiguous_faces_separated"] = counts.ambiguous_faces_separated;
  cases["tunnels"] = counts.tunnels;
  cases["skipped_cells"] = counts.skipped_cells;
  cases["components_removed"] = counts.components_removed;
  return cases;
}

Json extract_json(const MeshResult& mesh) {
  Json json;
  json["isovalue"] = mesh.isovalue ? Json(finite(*mesh.isovalue)) : Json(nullptr);
  json["isovalue_source"] = mesh.isovalue ? Json(name_of(mesh.isovalue_source)) : Json(nullptr);
  json["cases"] = Json::object();
  json["sub_cases"] = Json::object();
  if (!mesh.cases) return json;
  json["cases"] = object_of(named_cases(*mesh.cases));
  for (const SubCase& sub_case : mesh.cases->sub_cases) json["sub_cases"][sub_case.name] = sub_case.cells;
  return json;
}

Json finish_json(const std::optional<FinishResult>& finish) {
  if (!finish) return nullptr;
  Json json;
  json["steps"] = Json::array();
  for (const auto& step : finish->steps) {
    Json figures = Json::object();
    for (const auto& [name, value] : step.figures) figures[name] = finite(value);
    json["steps"].push_back(
        {{"name", to_string(step.step)}, {"refused", step.refused}, {"figures", std::move(figures)}});
  }
  json["T_mesh_world"] = pose_json(finish->T_mesh_world);
  return json;
}

Json texture_json(const std::optional<TextureResult>& texture) {
  if (!texture) return nullptr;
  return Json{{"refused", texture->refused},
              {"width", texture->width},
              {"height", texture->height},
              {"texel_m", finite(texture->texel_m)},
              {"charts", texture->charts},
              {"texels", texture->texels},
              {"seen_share", finite(texture->seen_share)},
              {"frames", texture->frames},
              {"bytes", texture->bytes}};
}

/// False for warnings that repeat what the report has in numbers, or what the files show.
bool is_reported(WarningCode code) {
  switch (code) {
    case WarningCode::kFramesDropped:
    case WarningCode::kRecordingEndsEarly:
    case WarningCode::kStoppedEarly:
    case WarningCode::kBudgetReached:
    case WarningCode::kPicturesLost:
    case WarningCode::kTurntableNotTried:
    case WarningCode::kMeshHasHoles:
    case WarningCode::kVolumeFile:
    case WarningCode::kSilhouettes:
    case WarningCode::kPointsOnly: return false;
    default: return true;
  }
}

Json warnings_json(const std::vector<ScanWarning>& warnings) {
  Json json = Json::array();
  for (const ScanWarning& warning : warnings) {
    if (is_reported(warning.code)) json.push_back(warning.text);
  }
  return json;
}

}  // namespace

const char* to_string(AngleSource source) {
  switch (source) {
    case AngleSource::kNone: return "none";
    case AngleSource::kRpm: return "rpm";
    case AngleSource::kStep: return "step";
    case AngleSource::kFile: return "file";
    case AngleSource::kRecording: return "recording";
  }
  return "";
}

std::size_t count_of(const TrackingResult& tracking, TrackState state) {
  return static_cast<std::size_t>(std::count_if(tracking.frames.begin(), tracking.frames.end(),
                                                [&](const TrackedFrame& frame) { return frame.state == state; }));
}

std::string report_json(const CommandRun& run) {
  const ScanResult& scan = run.scan;
  Json json;
  json["version"] = kVersion;
  json["input"] = scan.input;
  json["status"] = run.status;
  json["exit_code"] = run.exit_code;
  json["frames"] = frames_json(scan.frames);
  json["losses"] = scan.losses ? object_of(losses_by_name(*scan.losses)) : Json();
  json["warnings"] = warnings_json(scan.warnings);
  json["tracking"] = tracking_json(scan);
  json["turntable"] = turntable_json(scan.turntable);
  json["alignment"] = alignment_json(scan.alignment);
  json["silhouettes"] = silhouettes_json(scan.silhouettes);
  json["stages"] = stages_json(scan.stages);
  json["total_ms"] = finite(run.total_ms);
  json["peak_rss_mib"] = finite(run.peak_rss_mib);
  json["volume"] = volume_json(scan.volume);
  json["mesh"] = mesh_json(scan.mesh);
  json["holes"] = holes_json(scan.mesh.holes);
  json["doubled"] = doubled_json(scan.mesh.doubled);
  json["fit"] = fit_json(scan.mesh.fit);
  json["extract"] = extract_json(scan.mesh);
  json["finish"] = finish_json(scan.mesh.finish);
  json["texture"] = texture_json(scan.texture);
  json["classes"] = classes_json(scan.classes);
  json["files"] = object_of(files_of(run));
  json["config"] = Json::parse(config_to_json(scan.config));
  // Paths and messages may have bytes that are not UTF-8: these become the replacement character.
  return json.dump(2, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace) + "\n";
}

}  // namespace scanknit
