// The commands `calibrate target` and `calibrate camera`, as commands.h has the others.
#pragma once

#include <filesystem>
#include <optional>

#include "app/commands.h"
#include "calibrate/print/target_page.h"
#include "calibrate/target/calibration_target.h"

namespace scanknit {

struct CalibrateTargetArguments {
  std::filesystem::path output;  ///< ends in .pdf or .svg
  TargetType type = TargetType::kAprilGrid;
  std::optional<int> columns, rows;  ///< nothing: the type's usual number
  std::optional<double> size_m;      ///< nothing: the largest that fits
  Paper paper = Paper::kA4;
};

struct CalibrateCameraArguments {
  std::filesystem::path pictures, target, output;
  bool is_depth = false;  ///< the pictures are the depth camera's
};

[[nodiscard]] int calibrate_target_command(const CalibrateTargetArguments& arguments, const CommonArguments& common);
[[nodiscard]] int calibrate_camera_command(const CalibrateCameraArguments& arguments, const CommonArguments& common);

}  // namespace scanknit
