#include "app/cli_export.h"

#include <string>
#include <utility>

namespace scanknit {

void add_export_options(CLI::App& app, ConfigSources& config) {
  const auto add = [&](const std::string& name, const std::string& key, const std::string& words) {
    const auto set = [&config, key] { config.assignments.push_back(key + "=true"); };
    app.add_flag_callback(name, set, words + " (" + key + ")")->group("Smaller GLB files");
  };
  add("--quantize", "export.quantize", "Positions and normals as small integers: four fifths of the size");
  add("--compress", "export.compress",
      "For the web: half the size, with --quantize a quarter; Blender and Assimp do not read it");
}

CLI::App* add_report_command(CLI::App& app, ReportArguments& report, std::function<void()> chosen) {
  CLI::App* command = app.add_subcommand("report", "Draw report.html again, from report.json and what is beside it");
  command->add_option("folder", report.folder, "The folder that `run`, `capture`, `extract` or `align` wrote")
      ->required()
      ->type_name("OUT");
  command->final_callback(std::move(chosen));
  return command;
}

}  // namespace scanknit
