// What the command line says of written files.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "app/commands.h"

namespace scanknit {

/// `--quantize` and `--compress`, for every command that writes a GLB.
void add_export_options(CLI::App& app, ConfigSources& config);

/// The command `report`.
[[nodiscard]] CLI::App* add_report_command(CLI::App& app, ReportArguments& report, std::function<void()> chosen);

}  // namespace scanknit
