// Leaves out the pieces of a mesh that few frames confirm.
#pragma once

#include <span>

#include "core/mesh.h"
#include "export/picture/surface_fit.h"
#include "finish/mesh_steps.h"

namespace scanknit {

/// Removes the small pieces that the frames do not confirm. A frame confirms a vertex where its reading is nearer than
/// one sigma of its noise. On average a piece's vertices need three such frames (an eighth of them, where there are
/// fewer than 24), and half of all frames that have a reading within `band`: at a true surface it is two thirds. Noise
/// that floats beside a surface is within the band of many frames, and nearer than sigma in few. A piece with a tenth
/// of the largest one's area stays. `frames`: some of the scan's, evenly spread; without any, nothing is removed.
PiecesRemoved drop_crumbs(std::span<const PosedDepth> frames, const FitBand& band, Mesh& mesh);

}  // namespace scanknit
