// target.yaml: the description of a board.
#pragma once

#include <filesystem>
#include <string>

#include "calibrate/target/calibration_target.h"
#include "core/result.h"

namespace scanknit {

/// The keys type (aprilgrid, charuco), columns, rows and size (a length).
[[nodiscard]] std::string target_file_text(const CalibrationTarget& target);

/// All four keys are required. Errors: kInput: unreadable; kConfig, with line and column: not YAML, an unknown, missing
/// or repeated key, a value that validate() refuses.
[[nodiscard]] Result<CalibrationTarget> read_target_file(const std::filesystem::path& path);

}  // namespace scanknit
