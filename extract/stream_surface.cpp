#include "extract/stream_surface.h"

#include <algorithm>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "extract/blocks/dense_blocks.h"
#include "extract/cell/case_histogram.h"
#include "extract/extract_surface.h"
#include "extract/marching_cubes.h"

namespace scanknit {
namespace {

/// Slices that a step holds besides its own: the layer before, for gradients and pinched edges; the layer after, whose
/// vertices are numbered next; and the two slices that cells of that layer reach into.
constexpr int kExtraSlices = 2 * kBlockCells + 2;

/// A run of slices that moves up through the volume; each is read once.
class SliceWindow {
 public:
  /// Will hold `slices` at most.
  SliceWindow(SliceReader& reader, int slices) : reader_(reader), dims_(reader.header().dims) {
    samples_.reserve(slice_size() * static_cast<std::size_t>(std::min(slices, dims_.z())));
  }

  /// Holds the slices from `first` to before `last`, or to the volume's end.
  Result<void> move_to(int first, int last) {
    const int end = std::min(last, dims_.z());
    const auto forgotten = slice_size() * static_cast<std::size_t>(std::min(first, end_) - first_);
    samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(forgotten));
    samples_.resize(slice_size() * static_cast<std::size_t>(end - first));
    for (int k = std::max(first, end_); k < end; ++k) {
      const auto place = slice_size() * static_cast<std::size_t>(k - first);
      if (auto read = reader_.read_slice(k, std::span(samples_).subspan(place, slice_size())); !read) return read;
    }
    first_ = first;
    end_ = end;
    return {};
  }

  [[nodiscard]] DenseView view(const Eigen::Affine3d& T_world_ijk) const {
    return {samples_.data(), {dims_.x(), dims_.y(), end_ - first_}, T_world_ijk};
  }

 private:
  [[nodiscard]] std::size_t slice_size() const {
    return static_cast<std::size_t>(dims_.x()) * static_cast<std::size_t>(dims_.y());
  }

  SliceReader& reader_;
  Eigen::Vector3i dims_;
  std::vector<float> samples_;
  int first_ = 0;
  int end_ = 0;
};

/// Of the memory budget. In the worst case, white noise, what is known of the cells takes twice as much as the samples.
constexpr double kShareOfSamples = 0.25;
constexpr double kShareOfMesh = 0.25;

double budget_bytes(const ExtractConfig& config) {
  return static_cast<double>(config.memory_budget_mib) * (1 << 20);
}

/// Layers of eight slices that one step meshes.
Result<int> layers_per_step(const VolumeHeader& header, const ExtractConfig& config) {
  const double slice_bytes = sizeof(float) * static_cast<double>(header.dims.x()) * header.dims.y();
  const int least = kExtraSlices + kBlockCells;
  if (least * slice_bytes > budget_bytes(config)) {
    return Error{ErrorCode::kBudget,
                 std::to_string(least) + " slices of " + std::to_string(header.dims.x()) + " x " +
                     std::to_string(header.dims.y()) + " samples need more memory than " +
                     std::to_string(config.memory_budget_mib) + " MiB; raise extract.memory_budget",
                 "volume"};
  }
  const double slices = std::min<double>(header.dims.z(), kShareOfSamples * budget_bytes(config) / slice_bytes);
  return std::max(1, static_cast<int>(slices - kExtraSlices) / kBlockCells);
}

class Stream {
 public:
  Stream(SliceReader& reader, const Eigen::Affine3d& T_world_ijk, const ExtractConfig& config, const MeshPartSink& sink,
         int layers_per_step)
      : dims_(reader.header().dims),
        window_(reader, layers_per_step * kBlockCells + kExtraSlices),
        T_world_ijk_(T_world_ijk),
        config_(config),
        sink_(sink) {}

  /// Meshes the layers from `layer` on, `layers` of them or as many as there are.
  Result<void> step(int layer, int layers) {
    const int before = std::min(layer, 1);
    const int first_slice = kBlockCells * (layer - before);
    const int own = kBlockCells * (layer + layers);
    if (auto moved = window_.move_to(first_slice, own + kBlockCells + 2); !moved) return moved;
    const auto blocks = DenseBlocks::open(window_.view(T_world_ijk_), first_slice);
    if (!blocks) return blocks.error();

    const std::size_t per_layer = blocks->blocks_per_layer();
    const std::size_t all = blocks->origins().size();
    const BlockRange slab{per_layer * static_cast<std::size_t>(before),
                          std::min(all, per_layer * static_cast<std::size_t>(before + layers))};
    MarchingCubes marching(*blocks, config_, is_inside_high(config_.inside, false));
    CaseHistogram others;
    marching.count(slab, histogram_);
    marching.count({slab.end, std::min(all, slab.end + per_layer)}, others);
    marching.number(surface_.vertices);
    const MeshSize size = marching.size_of(slab);
    surface_.vertices += size.vertices;
    surface_.triangles += size.triangles;
    if (surface_.vertices > kMaxMeshVertices) return too_many_vertices();
    return write(marching, slab);
  }

  [[nodiscard]] int layers() const { return (dims_.z() + kBlockCells - 1) / kBlockCells; }

  [[nodiscard]] StreamedSurface result() const {
    StreamedSurface result = surface_;
    const bool is_mirrored = T_world_ijk_.linear().determinant() > 0;  // blocks count (k, j, i)
    result.cases = histogram_.counts(is_mirrored);
    return result;
  }

 private:
  /// In parts that the budget has room for.
  Result<void> write(const MarchingCubes& marching, BlockRange slab) {
    while (slab.begin < slab.end) {
      BlockRange part{slab.begin, slab.begin};
      double bytes = 0;
      while (part.end < slab.end) {
        const MeshSize size = marching.size_of({part.end, part.end + 1});
        bytes += static_cast<double>(2 * sizeof(Eigen::Vector3f) * size.vertices + sizeof(Triangle) * size.triangles);
        if (bytes > kShareOfMesh * budget_bytes(config_) && part.size() > 0) break;
        ++part.end;
      }
      marching.write(part, part_);
      if (auto taken = sink_(part_); !taken) return taken;
      slab.begin = part.end;
    }
    return {};
  }

  Eigen::Vector3i dims_;
  SliceWindow window_;
  const Eigen::Affine3d& T_world_ijk_;
  const ExtractConfig& config_;
  const MeshPartSink& sink_;
  CaseHistogram histogram_;
  StreamedSurface surface_;
  Mesh part_;
};

Result<StreamedSurface> stream(SliceReader& reader, const Eigen::Affine3d& T_world_ijk, const ExtractConfig& config,
                               const MeshPartSink& sink) {
  if (auto sound = check_extract_config(config); !sound) return sound.error();
  if (is_tetrahedral(config.decider))
    return Error{ErrorCode::kConfig, "tetrahedra are not streamed; choose another, or raise extract.memory_budget",
                 "extract.decider"};
  const auto layers = layers_per_step(reader.header(), config);
  if (!layers) return layers.error();
  Stream stream(reader, T_world_ijk, config, sink, *layers);
  for (int layer = 0; layer < stream.layers(); layer += *layers) {
    if (auto done = stream.step(layer, *layers); !done) return done.error();
  }
  return stream.result();
}

}  // namespace

Result<StreamedSurface> stream_surface(SliceReader& reader, const Eigen::Affine3d& T_world_ijk,
                                       const ExtractConfig& config, const MeshPartSink& sink) {
  try {
    return stream(reader, T_world_ijk, config, sink);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "memory ran out; lower extract.memory_budget", "extract"};
  }
}

}  // namespace scanknit
