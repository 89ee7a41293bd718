// The angles of a turntable's encoder.
#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// Degrees, one number a line: line n, counted from 0, is the recording's frame n. Lines that begin with # count
/// for nothing, nor do empty ones at the end. Errors: kConfig, with file and line.
[[nodiscard]] Result<std::vector<double>> read_angle_file(const std::filesystem::path& path);

}  // namespace scanknit
