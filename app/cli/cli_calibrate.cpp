#include "app/cli/cli_calibrate.h"

#include <CLI/CLI.hpp>

#include "app/cli/cli_options.h"
#include "core/files/quantity.h"

namespace scanknit {
namespace {

std::string why_no_page(const std::string& file) {
  const auto extension = std::filesystem::path(file).extension();
  const bool is_page = extension == ".pdf" || extension == ".svg";
  return is_page ? "" : file + ": no such output: give a file that ends in .pdf or .svg";
}

}  // namespace

void add_calibrate_target_options(CLI::App& command, CommandLine& line) {
  CalibrateTargetArguments& target = line.calibrate_target;
  command.add_option("-o,--output", target.output, "The page; beside it a .yaml of the same name describes the board")
      ->required()
      ->check(why_no_page)
      ->type_name("FILE.pdf|.svg");
  add_choice(command, line, {"--type", "aprilgrid (the default), charuco"}, target.type,
             {{"aprilgrid", TargetType::kAprilGrid}, {"charuco", TargetType::kCharuco}})
      ->type_name("TYPE");
  command.add_option("--columns", target.columns, "Tags, or squares of a ChArUco board, side by side; default: 6, 9")
      ->check(CLI::Range(2, 100))
      ->type_name("N");
  command.add_option("--rows", target.rows, "Tags or squares one above the other; default: 4, 6")
      ->check(CLI::Range(2, 100))
      ->type_name("N");
  const auto set_size = [&target](const std::string& text) {
    const auto length = parse_length(text);
    if (!length || length->metres <= 0) throw CLI::ValidationError("--size", "expected a length such as 30mm, 0.03");
    target.size_m = length->metres;
  };
  command
      .add_option_function<std::string>(
          "--size", set_size, "Side of a tag, or of a square: 30mm; default: as many whole millimetres as fit")
      ->type_name("LENGTH");
  add_choice(command, line, {"--paper", "a4 (the default), a3, letter"}, target.paper,
             {{"a4", Paper::kA4}, {"a3", Paper::kA3}, {"letter", Paper::kLetter}})
      ->type_name("PAPER");
}

void add_calibrate_camera_options(CLI::App& command, CalibrateCameraArguments& camera) {
  command
      .add_option("pictures", camera.pictures,
                  "A recording in which the board is moved, or a folder of .png or .jpg pictures of it")
      ->required()
      ->type_name("RECORDING");
  command.add_option("--target", camera.target, "The board, as `calibrate target` described it")
      ->required()
      ->type_name("TARGET.yaml");
  command.add_option("-o,--output", camera.output, "The cameras, for acquire.camera")
      ->required()
      ->type_name("CAMERA.yaml");
  command.add_flag("--depth", camera.is_depth,
                   "The pictures are infrared ones of the depth camera, in its size and as it sees them");
}

void add_calibrate_rig_options(CLI::App& command, CalibrateRigArguments& rig) {
  command
      .add_option("recordings", rig.recordings,
                  "One of each camera, of the same time and board; the first camera is the rig")
      ->required()
      ->expected(2, 64)
      ->type_name("RECORDING");
  command.add_option("--target", rig.target, "The board, as `calibrate target` described it")
      ->required()
      ->type_name("TARGET.yaml");
  command
      .add_option("--camera", rig.cameras,
                  "Each camera's own calibration, once for each recording in their order; default: measured here")
      ->type_name("CAMERA.yaml")
      ->allow_extra_args(false);
  command.add_option("-o,--output", rig.output, "The cameras, for `run --rig`")->required()->type_name("RIG.yaml");
}

}  // namespace scanknit
