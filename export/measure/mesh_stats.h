// A mesh's counts as JSON, for the report and for `scanknit info`.
#pragma once

#include <string>

#include "core/mesh.h"

namespace scanknit {

/// One JSON object on one line: the "mesh" of report.schema.json.
[[nodiscard]] std::string mesh_check_json(const MeshCheck& check);

}  // namespace scanknit
