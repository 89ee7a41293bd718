// The angles of a turntable's encoder.
#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// Reads degrees, one number a line: line n, counted from 0, belongs to frame n of the recording. Skips lines that
/// begin with #, and empty lines at the end. Errors: kConfig, with file and line.
[[nodiscard]] Result<std::vector<double>> read_angle_file(const std::filesystem::path& path);

}  // namespace scanknit
