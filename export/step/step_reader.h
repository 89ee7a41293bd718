// STEP (ISO 10303-21) models: the surfaces of a CAD program, as triangles.
#pragma once

#include <string_view>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/mesh/read_mesh.h"

namespace scanknit {

/// What Open CASCADE does for this room: in a module, libscanknit_step_reader.so, in a package of its own.
struct StepReader {
  /// As read_step(), but may crash or take any memory and time on a broken file.
  Result<Mesh> (*read)(std::string_view bytes, const Limits& limits, MeshNotes* notes);
};

/// The faces of all solids and shells, in millimetres whatever unit the file states, as triangles whose corners lie on
/// the surface and which are at most kStepDeviation of the model's diagonal from it. Faces that meet share their
/// vertices. Tried in a child process first. Adds a warning for faces that cannot be meshed. Errors (kInput): not a
/// STEP file, no face in it, more triangles than the limit, or what crashes its library; kInput also when the module is
/// missing: what is to be installed.
[[nodiscard]] Result<Mesh> read_step(std::string_view bytes, const Limits& limits, MeshNotes* notes = nullptr);

inline constexpr double kStepDeviation = 1e-4;

}  // namespace scanknit
