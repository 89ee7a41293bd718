// Writes the configuration as YAML to edit, as JSON, as a JSON Schema, and as a page of documentation.
#pragma once

#include <string>

#include "scan/scan_config.h"

namespace scanknit {

/// All keys, each with its meaning, unit and range as a comment. Parsing the text gives the same configuration, bit for
/// bit.
[[nodiscard]] std::string config_to_yaml(const ScanConfig& config);

/// One object, nested as the YAML is; lengths in metres, memory in MiB, `auto` as null.
[[nodiscard]] std::string config_to_json(const ScanConfig& config);

/// Draft 2020-12, for editors: "# yaml-language-server: $schema=...".
[[nodiscard]] std::string config_json_schema();

/// The text of docs/configuration.md. `run_defaults`: the values that `scanknit run` begins with.
[[nodiscard]] std::string config_markdown(const ScanConfig& run_defaults);

}  // namespace scanknit
