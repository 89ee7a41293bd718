// Leaves out the pieces of a mesh that few frames confirm.
#pragma once

#include <span>

#include "core/mesh.h"
#include "export/picture/surface_fit.h"
#include "finish/mesh_steps.h"

namespace scanknit {

/// Removes the small pieces that the frames do not confirm. A frame confirms a vertex if its reading is within one
/// sigma of the noise. A piece stays if its vertices are confirmed, on average, by at least three frames (an eighth of
/// the frames, if there are fewer than 24) and by at least half of the frames that have a reading within `band`. For a
/// true surface that is two thirds; noise that floats beside a surface is within the band of many frames, but within
/// sigma of few. A piece with a tenth of the largest one's area always stays. `frames`: some of the scan's, evenly
/// spread; without any, nothing is removed.
PiecesRemoved drop_crumbs(std::span<const PosedDepth> frames, const FitBand& band, Mesh& mesh);

}  // namespace scanknit
