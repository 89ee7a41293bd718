// describe_shape(): what `info` says of meshes and volumes, whose rooms it loads only for them.
#pragma once

#include <string>

#include "app/commands.h"
#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

/// Of a file or folder that is a mesh, an OpenVDB file or another volume: JSON with the entries that info prints, in
/// this order. Errors: those of reading it.
[[nodiscard]] Result<std::string> describe_shape(const InfoArguments& arguments, const ScanConfig& config);

}  // namespace scanknit
