// The arguments of the program's commands, from Python's. Each has what is not said by keys of the configuration.
#pragma once

#include <filesystem>
#include <vector>

#include "app/commands.h"
#include "python/keywords.h"

namespace scanknit {

/// Presets and settings.
[[nodiscard]] ConfigSources config_sources(Keywords& keywords);

[[nodiscard]] RunArguments run_arguments(const std::filesystem::path& recording, const std::filesystem::path& output,
                                         Keywords& keywords);
[[nodiscard]] CaptureArguments capture_arguments(const std::filesystem::path& output, Keywords& keywords);
[[nodiscard]] AlignArguments align_arguments(std::vector<std::filesystem::path> inputs,
                                             const std::filesystem::path& output, Keywords& keywords);
/// An isovalue becomes a setting of `config`.
[[nodiscard]] ExtractArguments extract_arguments(const std::filesystem::path& volume,
                                                 const std::filesystem::path& output, Keywords& keywords,
                                                 ConfigSources& config);

}  // namespace scanknit
