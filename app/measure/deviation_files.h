// The files that `distance` writes of two meshes.
#pragma once

#include "app/measure/deviation_text.h"
#include "core/mesh.h"

namespace scanknit {

/// Writes into `folder`: deviation.ply, the mesh in the reference's frame, in the colours of its deviations;
/// deviation.png, two views of it with a scale; histogram.svg; distance.json; report.html, which shows it all. Adds
/// them to `comparison.files`. The mesh gets the colours. Errors: kOutput.
[[nodiscard]] Result<void> write_deviation_files(Comparison& comparison, Mesh& mesh,
                                                 const std::filesystem::path& folder);

}  // namespace scanknit
