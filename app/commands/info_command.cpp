#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "acquire/frame_source.h"
#include "acquire/lidar/sweep_source.h"
#include "acquire/sensor/sensor_profile.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/modules/commands_module.h"
#include "core/files/lower_extension.h"
#include "core/system/module.h"
#include "export/mesh/write_mesh.h"

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

/// What is no recording is described by the rooms that read meshes and volumes.
Result<Json> describe_other(const InfoArguments& arguments, const ScanConfig& config) {
  const auto module =
      load_module<CommandsModule>(CommandsModule::kName, "It comes with ScanKnit: install ScanKnit again");
  if (!module) return module.error();
  const auto text = (*module)->describe_shape(arguments, config);
  return text ? Result<Json>(Json::parse(*text)) : text.error();
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
  const auto volume = describe_other(arguments, config);
  std::error_code ignored;
  if (volume || !std::filesystem::is_directory(arguments.file, ignored)) return volume;
  if (volume.error().code != ErrorCode::kUsage) return recording.error();
  return Error{ErrorCode::kInput, recording.error().message + "; or is it a volume? " + volume.error().message,
               recording.error().where};
}

Result<Json> describe(const InfoArguments& arguments, const ScanConfig& config) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(arguments.file, ignored);
  const bool is_shape = !is_folder && (is_mesh_path(arguments.file) || lower_extension(arguments.file) == ".vdb");
  const VolumeOptions& options = arguments.options;
  if (is_shape || options.dims || options.spacing) return describe_other(arguments, config);
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
