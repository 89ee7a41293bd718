#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "app/cli/exit_codes.h"
#include "app/commands/commands.h"
#include "app/terminal/signals.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "synth/scene/scene.h"
#include "synth/scene/scene_names.h"
#include "synth/write_recording.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

Result<std::unique_ptr<SyntheticScene>> open_scene(const SynthArguments& arguments, Console& console) {
  if (!is_mesh_path(arguments.scene)) return make_scene(arguments.scene);
  MeshNotes notes;
  auto mesh = read_mesh(arguments.scene, {}, &notes);
  if (!mesh) return mesh.error();
  for (const std::string& warning : notes.warnings) console.warn(fmt::format("{}: {}", arguments.scene, warning));
  return make_mesh_scene(std::move(*mesh), arguments.size_m);
}

/// A camera with the default horizontal field of view, square pixels, and the principal point in the middle.
CameraIntrinsics camera_of(int width, int height) {
  const SynthConfig standard;
  const double focal = standard.intrinsics.fx * width / standard.intrinsics.width;
  return {width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0};
}

SynthConfig synth_config(const SynthArguments& arguments) {
  SynthConfig config;
  config.frames = arguments.frames;
  config.intrinsics = camera_of(arguments.width, arguments.height);
  config.noise = arguments.has_noise;
  config.seed = arguments.seed;
  config.jpeg_colour = arguments.has_jpeg_colour;
  if (arguments.is_on_turntable) {
    config.turntable = RigConfig{.turns = arguments.turns,
                                 .angle_noise_rad = arguments.angle_noise_degrees * std::numbers::pi / 180,
                                 .is_on_side = arguments.is_on_side,
                                 .has_hand = arguments.has_hand};
  }
  return config;
}

int list_scenes(const CommonArguments& common) {
  if (common.is_json) return print_result(Json(kSceneNames).dump() + "\n", common);
  return print_result(fmt::format("{}\n", fmt::join(kSceneNames, "\n")), common);
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
  const std::string next = arguments.is_on_turntable
                               ? fmt::format("scanknit run {} --preset turntable -o OUT", folder)
                               : fmt::format("scanknit run {0} -o OUT && scanknit distance OUT/model.ply {0}", folder);
  return print_result(fmt::format("Written  {0}: {1} frames; {2} of {3} truth points are seen\n"
                                  "Next     {4}\n",
                                  folder, summary.frames, summary.visible_points, summary.truth_points, next),
                      common);
}

}  // namespace

int synth_command(const SynthArguments& arguments, const CommonArguments& common) {
  if (arguments.only_list) return list_scenes(common);
  const StopOnSignal stop_on_signal;  // must come before any other thread
  Console console(common.verbosity);
  const auto scene = open_scene(arguments, console);
  if (!scene) return fail(scene.error(), common);
  const auto progress = [&](std::size_t done, std::size_t total) { console.progress("rendering", done, total); };
  const auto summary =
      write_synthetic_recording(**scene, synth_config(arguments), arguments.output, progress, stop_on_signal.token());
  if (!summary) return fail(summary.error(), common);
  const int printed = print_summary(*summary, arguments, common);
  return summary->was_stopped ? kExitInterrupted : printed;
}

}  // namespace scanknit
