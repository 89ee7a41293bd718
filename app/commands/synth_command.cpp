#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/calibrate/target_file.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"
#include "core/files/atomic_file.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "synth/path/path_names.h"
#include "synth/path/recorded_motion.h"
#include "synth/scene/board_scene.h"
#include "synth/scene/person_names.h"
#include "synth/scene/scene.h"
#include "synth/scene/scene_names.h"
#include "synth/sensor/sensor_keys.h"
#include "synth/sensor/sensor_names.h"
#include "synth/write_recording.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kTargetFile = "target.yaml";

Result<std::unique_ptr<SyntheticScene>> open_scene(const SynthArguments& arguments, Console& console) {
  if (!is_mesh_path(arguments.scene)) return make_scene(arguments.scene);
  MeshNotes notes;
  auto mesh = read_mesh(arguments.scene, {}, &notes);
  if (!mesh) return mesh.error();
  for (const std::string& warning : notes.warnings) console.warn(fmt::format("{}: {}", arguments.scene, warning));
  return make_mesh_scene(std::move(*mesh), arguments.size_m);
}

/// The sensor that was asked for, with the values that were set; nothing if none was.
Result<std::optional<RenderedSensor>> sensor_of(const SynthArguments& arguments) {
  const bool is_asked_for = !arguments.sensor.empty() || !arguments.sensor_values.empty();
  if (!is_asked_for) return std::optional<RenderedSensor>();
  auto sensor = make_sensor(arguments.sensor.empty() ? "ideal" : arguments.sensor);
  if (!sensor) return sensor.error();
  for (const std::string& assignment : arguments.sensor_values) {
    if (auto done = set_sensor_value(*sensor, assignment); !done) return done.error();
  }
  if (auto valid = validate(*sensor); !valid) return valid.error();
  return std::optional<RenderedSensor>(*std::move(sensor));
}

/// Without a sensor: a camera with the default horizontal field of view, whatever its shape.
CameraIntrinsics camera_without_sensor(const SynthArguments& arguments) {
  const CameraIntrinsics standard = SynthConfig().intrinsics;
  const int width = arguments.width > 0 ? arguments.width : standard.width;
  const int height = arguments.height > 0 ? arguments.height : standard.height;
  const double focal = standard.fx * width / standard.width;
  return {width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0};
}

Result<SynthConfig> synth_config(const SynthArguments& arguments) {
  SynthConfig config;
  auto sensor = sensor_of(arguments);
  if (!sensor) return sensor.error();
  config.sensor = *std::move(sensor);
  if (!arguments.trajectory.empty()) {
    auto recorded = read_recorded_path(arguments.trajectory);
    if (!recorded) return recorded.error();
    config.recorded_path = *std::move(recorded);
  }
  config.path = arguments.path;
  config.person = arguments.person;
  config.frames = arguments.frames;
  config.intrinsics =
      config.sensor ? camera_of(*config.sensor, arguments.width, arguments.height) : camera_without_sensor(arguments);
  config.noise = arguments.has_noise;
  config.seed = arguments.seed;
  config.jpeg_colour = arguments.has_jpeg_colour;
  config.masks = arguments.has_masks;
  if (arguments.is_on_turntable) {
    config.turntable = RigConfig{.turns = arguments.turns,
                                 .angle_noise_rad = arguments.angle_noise_degrees * std::numbers::pi / 180,
                                 .is_on_side = arguments.is_on_side,
                                 .has_hand = arguments.has_hand};
  }
  return config;
}

Json sensor_values_json(const RenderedSensor& sensor) {
  Json values;
  for (const SensorKey& key : sensor_keys()) values[std::string(key.name)] = value_of(key, sensor);
  return values;
}

int list_as_json(const std::vector<RenderedSensor>& sensors, const CommonArguments& common) {
  Json keys = Json::array();
  for (const SensorKey& key : sensor_keys()) {
    keys.push_back({{"name", key.name},
                    {"unit", to_string(key.unit)},
                    {"lowest", key.lowest},
                    {"highest", key.highest},
                    {"meaning", key.meaning}});
  }
  Json by_name;
  for (const RenderedSensor& sensor : sensors) by_name[sensor.name] = sensor_values_json(sensor);
  const Json json = {{"scenes", kSceneNames},
                     {"paths", kPathNames},
                     {"persons", kPersonNames},
                     {"sensors", by_name},
                     {"sensor_keys", keys}};
  return print_result(json.dump(2) + "\n", common);
}

/// A column for each sensor.
std::string key_table(const std::vector<RenderedSensor>& sensors) {
  std::string table = fmt::format("{:<24}", "Values of sensors");
  for (const RenderedSensor& sensor : sensors) table += fmt::format("{:>12}", sensor.name);
  table += "\n";
  for (const SensorKey& key : sensor_keys()) {
    table += fmt::format("  {:<22}", key.name);
    for (const RenderedSensor& sensor : sensors) table += fmt::format("{:>12.6g}", value_of(key, sensor));
    table += fmt::format("  {:<6}{}\n", to_string(key.unit), key.meaning);
  }
  return table;
}

int list_everything(const CommonArguments& common) {
  std::vector<RenderedSensor> sensors;
  for (const std::string_view name : kSensorNames) sensors.push_back(*make_sensor(name));
  if (common.is_json) return list_as_json(sensors, common);
  return print_result(fmt::format("Scenes\n  {}\nPaths\n  {}\nPersons\n  {}\n{}", fmt::join(kSceneNames, "\n  "),
                                  fmt::join(kPathNames, "\n  "), fmt::join(kPersonNames, "\n  "), key_table(sensors)),
                      common);
}

/// Beside the pictures of a board: what `calibrate camera` must know of it.
Result<void> describe_board(const SynthArguments& arguments) {
  if (arguments.scene != kBoardSceneName) return {};
  return write_file_atomically(arguments.output / kTargetFile, target_file_text(kSceneBoard));
}

std::string next_step(const SynthArguments& arguments) {
  const std::string folder = arguments.output.string();
  if (arguments.scene == kBoardSceneName) {
    return fmt::format("scanknit calibrate camera {0} --target {0}/{1} -o CAMERA.yaml", folder, kTargetFile);
  }
  if (arguments.is_on_turntable) return fmt::format("scanknit run {} --preset turntable -o OUT", folder);
  return fmt::format("scanknit run {0} -o OUT && scanknit distance OUT/model.ply {0}", folder);
}

int print_summary(const SynthSummary& summary, const SynthArguments& arguments, const CommonArguments& common) {
  const std::string folder = arguments.output.string();
  if (common.is_json) {
    const Json json = {{"folder", folder},
                       {"frames", summary.frames},
                       {"truth_points", summary.truth_points},
                       {"visible_points", summary.visible_points}};
    return print_result(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", common);
  }
  if (common.verbosity == Verbosity::kQuiet) return kExitOk;
  return print_result(
      fmt::format("Written  {0}: {1} frames; {2} of {3} truth points are seen\n"
                  "Next     {4}\n",
                  folder, summary.frames, summary.visible_points, summary.truth_points, next_step(arguments)),
      common);
}

}  // namespace

int synth_command(const SynthArguments& arguments, const CommonArguments& common) {
  if (arguments.only_list) return list_everything(common);
  const StopOnSignal stop_on_signal;  // must come before any other thread
  Console console(common.verbosity);
  const auto scene = open_scene(arguments, console);
  if (!scene) return fail(scene.error(), common);
  const auto config = synth_config(arguments);
  if (!config) return fail(config.error(), common);
  const auto progress = [&](std::size_t done, std::size_t total) { console.progress("rendering", done, total); };
  const auto summary = write_synthetic_recording(**scene, *config, arguments.output, progress, stop_on_signal.token());
  if (!summary) return fail(summary.error(), common);
  if (auto done = describe_board(arguments); !done) return fail(done.error(), common);
  const int printed = print_summary(*summary, arguments, common);
  return summary->was_stopped ? kExitInterrupted : printed;
}

}  // namespace scanknit
