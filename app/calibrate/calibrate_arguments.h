// The commands `calibrate target`, `calibrate camera` and `calibrate rig`, as commands.h has the others.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

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

struct CalibrateRigArguments {
  std::vector<std::filesystem::path> recordings;
  std::filesystem::path target, output;
  std::vector<std::filesystem::path> cameras;  ///< one for each recording; empty: measured
};

[[nodiscard]] int calibrate_target_command(const CalibrateTargetArguments& arguments, const CommonArguments& common);
[[nodiscard]] int calibrate_camera_command(const CalibrateCameraArguments& arguments, const CommonArguments& common);
[[nodiscard]] int calibrate_rig_command(const CalibrateRigArguments& arguments, const CommonArguments& common);

}  // namespace scanknit
