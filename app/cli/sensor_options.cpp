#include "app/cli/sensor_options.h"

#include <CLI/CLI.hpp>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/cli/cli_options.h"
#include "synth/path/path_names.h"
#include "synth/scene/person_names.h"
#include "synth/sensor/sensor_names.h"

namespace scanknit {
namespace {

/// Each word with the enumerator of its number.
template <typename Kind, std::size_t N>
std::vector<std::pair<std::string, Kind>> choices(const std::array<std::string_view, N>& words) {
  std::vector<std::pair<std::string, Kind>> pairs;
  for (std::size_t i = 0; i < N; ++i) pairs.emplace_back(words[i], static_cast<Kind>(i));
  return pairs;
}

}  // namespace

void add_sensor_options(CLI::App& command, CommandLine& line, CLI::Option* noise) {
  SynthArguments& synth = line.synth;
  const std::string group = "Sensor, path, people";
  std::vector<std::pair<std::string, std::string>> sensors;
  for (const std::string_view name : kSensorNames) sensors.emplace_back(name, name);
  add_choice(command, line, {"--sensor", "Pictures as this sensor takes them: ideal, kinect1, d435, phone_lidar"},
             synth.sensor, sensors)
      ->excludes(noise)
      ->type_name("SENSOR")
      ->group(group);
  command
      .add_option("--sensor-set", synth.sensor_values,
                  "One value of the sensor (--list), may be repeated: disparity.noise=0.1px, or an effect: edges=off")
      ->allow_extra_args(false)
      ->excludes(noise)
      ->type_name("KEY=VALUE")
      ->group(group);
  auto* path =
      add_choice(command, line, {"--path", "How the camera is carried: scene (as a machine), hand, turns, walk, orbit"},
                 synth.path, choices<PathKind>(kPathNames))
          ->type_name("PATH")
          ->group(group);
  command
      .add_option("--trajectory", synth.trajectory, "Fly this recorded path (TUM format), from the scene's beginning")
      ->excludes(path)
      ->type_name("FILE")
      ->group(group);
  add_choice(command, line, {"--person", "Who is in the picture: nobody, sitting, walking"}, synth.person,
             choices<PersonKind>(kPersonNames))
      ->type_name("WHO")
      ->group(group);
}

}  // namespace scanknit
