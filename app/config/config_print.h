// The configuration written out: as YAML to edit, as JSON for machines, as a JSON Schema, as a page of documentation.
#pragma once

#include <string>

#include "scan/scan_config.h"

namespace scanknit {

/// Every key with its meaning, unit and range as a comment. Parsing it back gives the same configuration, bit for bit.
[[nodiscard]] std::string config_to_yaml(const ScanConfig& config);

/// One object, nested as the YAML is; lengths in metres, memory in MiB, `auto` as null.
[[nodiscard]] std::string config_to_json(const ScanConfig& config);

/// Draft 2020-12, for editors: "# yaml-language-server: $schema=...".
[[nodiscard]] std::string config_json_schema();

/// docs/configuration.md. `run_defaults` are what `scanknit run` begins with.
[[nodiscard]] std::string config_markdown(const ScanConfig& run_defaults);

}  // namespace scanknit
