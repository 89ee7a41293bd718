#include <fmt/format.h>

#include <openvdb/openvdb.h>
#include <openvdb/tools/Count.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "acquire/frame_source.h"
#include "acquire/lidar/sweep_source.h"
#include "acquire/sensor/sensor_profile.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "core/mesh.h"
#include "export/measure/mesh_stats.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "export/spill/stitch_borders.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/volume/extract_volume.h"
#include "scan/volume/open_volume_file.h"
#include "scan/volume/volume_values.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

Json intrinsics_json(const std::optional<CameraIntrinsics>& camera) {
  if (!camera) return nullptr;
  return {{"width", camera->width}, {"height", camera->height}, {"fx", camera->fx},
          {"fy", camera->fy},       {"cx", camera->cx},         {"cy", camera->cy}};
}

Json sensor_json(const std::optional<RecognisedSensor>& sensor) {
  const SensorProfile* profile = sensor ? find_sensor(sensor->model) : nullptr;
  return profile != nullptr ? Json(profile->name) : Json(nullptr);
}

Json recording_json(const RecordingInfo& info) {
  Json json = {{"kind", "recording"},
               {"format", info.format},
               {"sensor", sensor_json(info.sensor)},
               {"frames", info.frames},
               {"width", info.intrinsics ? Json(info.intrinsics->width) : Json(nullptr)},
               {"height", info.intrinsics ? Json(info.intrinsics->height) : Json(nullptr)},
               {"intrinsics", intrinsics_json(info.intrinsics)},
               {"duration_s", info.duration_s ? Json(*info.duration_s) : Json(nullptr)},
               {"has_poses", info.frames_with_pose > 0},
               {"frames_with_pose", info.frames_with_pose},
               {"has_colour", info.has_colour},
               {"colour_intrinsics", intrinsics_json(info.colour_intrinsics)},
               {"warnings", info.warnings}};
  if (!info.topics.empty()) json["topics"] = info.topics;
  return json;
}

/// A sweep counts as a frame.
Json sweeps_json(const SweepInfo& info) {
  RecordingInfo recording;
  recording.format = info.format;
  recording.folder = info.folder;
  recording.frames = info.sweeps;
  recording.frames_with_pose = info.sweeps_with_pose;
  recording.duration_s = info.duration_s;
  recording.warnings = info.warnings;
  recording.topics = info.topics;
  if (info.sweeps_with_pose == 0) recording.warnings.push_back("no poses; `run` expects " + info.expected_poses);
  return recording_json(recording);
}

Json vector_json(const openvdb::Vec3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json volume_json(const LoadedVolume& volume) {
  const openvdb::FloatGrid& field = *volume.field;
  const openvdb::CoordBBox box = field.evalActiveVoxelBoundingBox();
  Json grids = Json::array({field.getName()});
  if (volume.weight) grids.push_back(volume.weight->getName());
  if (volume.colour) grids.push_back(volume.colour->getName());
  Json bounds = nullptr;
  if (!box.empty()) {
    bounds = Json::array({vector_json(field.indexToWorld(box.min())), vector_json(field.indexToWorld(box.max()))});
  }
  const openvdb::math::MinMax<float> values = openvdb::tools::minMax(field.tree());
  return {{"kind", "volume"},
          {"format", "OpenVDB"},
          {"grids", grids},
          {"voxel_size_m", field.voxelSize().x()},
          {"active_voxels", field.activeVoxelCount()},
          {"bounds_m", bounds},
          {"is_signed_distance", volume.is_signed_distance},
          {"value_range", box.empty() ? Json(nullptr) : Json::array({values.min(), values.max()})}};
}

Json vector_json(const Eigen::Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Result<Json> volume_json(SliceReader& reader) {
  const auto census = take_census(values_of(reader));
  if (!census) return census.error();
  const VolumeHeader& header = reader.header();
  const Eigen::Matrix3d& columns = header.T_file_index.linear();
  Json directions = Json::array();
  for (int axis = 0; axis < 3; ++axis) directions.push_back(vector_json(columns.col(axis).normalized()));
  const bool has_values = census->count() > 0;
  return Json{{"kind", "volume"},
              {"format", header.format},
              {"dims", Json::array({header.dims.x(), header.dims.y(), header.dims.z()})},
              {"sample_type", header.sample_type},
              {"spacing", vector_json(columns.colwise().norm().transpose())},
              {"origin", vector_json(header.T_file_index.translation())},
              {"directions", directions},
              {"metres_per_unit", header.metres_per_unit},
              {"value_range", has_values ? Json::array({census->min(), census->max()}) : Json(nullptr)},
              {"known_samples", census->count()},
              {"warnings", header.warnings}};
}

/// Describes the topology of the surface: joins the vertices that the seams of a texture have split.
Json mesh_json(Mesh mesh, const MeshNotes& notes) {
  const std::size_t vertices = mesh.positions_m.size();
  const StitchedSeams seams = notes.has_texture_coordinates ? stitch_seams(mesh) : StitchedSeams{};
  std::vector<std::string> warnings = notes.warnings;
  if (seams.guesses > 0) {
    warnings.push_back(
        fmt::format("{} edges of the texture's seams lie in the same place as others, so the program guesses which "
                    "belong together. A file that was written without --quantize needs no guess",
                    seams.guesses));
  }
  Json json = {{"kind", "mesh"},
               {"has_normals", !mesh.normals.empty()},
               {"has_colours", !mesh.colours.empty()},
               {"warnings", warnings}};
  json.update(Json::parse(mesh_check_json(check_mesh(mesh))));
  json["vertices"] = vertices;
  json["seam_vertices"] = seams.vertices;
  return json;
}

Result<Json> describe_volume(const InfoArguments& arguments, const ScanConfig& config) {
  const auto reader = open_volume_file(arguments.file, arguments.options, config.extract);
  return reader ? volume_json(**reader) : reader.error();
}

/// For a folder without options, which may be a recording or a volume.
Result<Json> describe_recording_or_volume(const InfoArguments& arguments, const ScanConfig& config) {
  AcquireConfig acquire = config.acquire;
  acquire.only_describes = true;
  if (is_sweep_recording(arguments.file, acquire)) {
    const auto sweeps = open_sweeps(arguments.file, acquire);
    return sweeps ? Result<Json>(sweeps_json((*sweeps)->info())) : sweeps.error();
  }
  const auto recording = open_recording(arguments.file, acquire);
  if (recording) return recording_json((*recording)->info());
  constexpr std::array kEndsOfRecordings = {".mcap", ".db3", ".bag", ".oni", ".sens", ".r3d", ".mkv"};
  const auto extension = arguments.file.extension();
  if (std::find(kEndsOfRecordings.begin(), kEndsOfRecordings.end(), extension) != kEndsOfRecordings.end()) {
    return recording.error();
  }
  const auto volume = describe_volume(arguments, config);
  std::error_code ignored;
  if (volume || !std::filesystem::is_directory(arguments.file, ignored)) return volume;
  if (volume.error().code != ErrorCode::kUsage) return recording.error();
  return Error{ErrorCode::kInput, recording.error().message + "; or is it a volume? " + volume.error().message,
               recording.error().where};
}

Result<Json> describe(const InfoArguments& arguments, const ScanConfig& config) {
  const std::filesystem::path& file = arguments.file;
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(file, ignored);
  if (!is_folder && is_mesh_path(file)) {
    MeshNotes notes;
    auto mesh = read_mesh(file, {}, &notes);
    return mesh ? Result<Json>(mesh_json(*std::move(mesh), notes)) : mesh.error();
  }
  if (!is_folder && is_vdb(file)) {
    if (auto known = refuse_options_for_vdb(file, arguments.options); !known) return known.error();
    const auto volume = load_volume(file);
    return volume ? Result<Json>(volume_json(*volume)) : volume.error();
  }
  const VolumeOptions& options = arguments.options;
  if (options.dims || options.spacing) return describe_volume(arguments, config);
  return describe_recording_or_volume(arguments, config);
}

/// One line "name value" for each entry.
std::string lines_of(const Json& json) {
  std::string text;
  for (const auto& [name, value] : json.items()) {
    const std::string shown = value.is_string() ? value.get<std::string>() : value.dump();
    text += fmt::format("{:24} {}\n", name, value.is_null() ? "unknown" : shown);
  }
  return text;
}

}  // namespace

int info_command(const InfoArguments& arguments, const CommonArguments& common) {
  const auto loaded = load_config(common.config);
  if (!loaded) return fail(loaded.error(), common);
  const auto json = describe(arguments, loaded->config);
  if (!json) return fail(json.error(), common);
  constexpr auto kReplace = Json::error_handler_t::replace;  // names of grids need not be UTF-8
  return print_result(common.is_json ? json->dump(2, ' ', false, kReplace) + "\n" : lines_of(*json), common);
}

}  // namespace scanknit
