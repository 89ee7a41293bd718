// TsdfVolume: the live volume: OpenVDB grids with the same transform and topology.
#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <unordered_set>
#include <vector>

#include "core/field_view.h"
#include "core/image.h"
#include "core/result.h"
#include "fusion/fusion_config.h"

namespace scanknit {

class BlockBudget;
class BlockIndex;
class VolumeMemory;
struct NewBlock;

/// The values of one sample.
struct Voxel {
  float tsdf_m = 0;            ///< see TsdfVolume
  float weight = 0;            ///< 0: unknown
  std::optional<Rgb8> colour;  ///< nothing: no colour was seen
};

/// Three grids named "tsdf", "weight", "colour", a sample AT index (i, j, k), world = voxel_size * index, allocated in
/// leaves of 8^3 voxels. Per voxel:
///   weight  sum of the observations' weights; 0 = unknown (never seen), > 0 = observed
///   tsdf    mean signed distance, metres, positive in free space; background +truncation
///   colour  mean sRGB-encoded colour
/// Ten bytes: weight and colour are codes (core/voxel_codes.h). A voxel is active if its weight is > 0, else inactive.
/// Free space has weight > 0 and tsdf = +truncation.
class TsdfVolume {
 public:
  /// Errors (kConfig): a voxel size or truncation that is not positive and finite; a budget that is too small for any
  /// scan.
  [[nodiscard]] static Result<TsdfVolume> create(const FusionConfig& config);

  TsdfVolume(TsdfVolume&&) noexcept;
  TsdfVolume& operator=(TsdfVolume&&) noexcept;
  ~TsdfVolume();

  [[nodiscard]] const FusionConfig& config() const { return config_; }
  /// Changes the budget for new blocks, of volumes that share one.
  void set_memory_budget_mib(std::size_t budget_mib) { config_.memory_budget_mib = budget_mib; }
  [[nodiscard]] const openvdb::FloatGrid& tsdf() const { return *tsdf_; }
  [[nodiscard]] const WeightCodeGrid& weight() const { return *weight_; }
  [[nodiscard]] const ColourCodeGrid& colour() const { return *colour_; }
  /// A view for extract_surface() and others that read the volume, which keeps its grids.
  [[nodiscard]] FieldView field_view() const;
  /// Reads one voxel by a search in three trees; for few voxels only.
  [[nodiscard]] Voxel voxel(const openvdb::Coord& index) const;

  [[nodiscard]] std::size_t blocks() const;         ///< leaves of 8^3 voxels
  [[nodiscard]] std::size_t active_voxels() const;  ///< observed voxels
  [[nodiscard]] std::size_t memory_bytes() const;   ///< of the blocks and the trees above them

  /// True after integrate() could not add blocks because of the budget.
  bool is_budget_reached = false;
  std::uint32_t frames = 0;  ///< number of integrated frames

  /// Writes the three grids, all or nothing, in stock types that any OpenVDB program opens: weights as floats, colours
  /// as three floats from 0 to 1, negative if no colour was seen. `view_sigma_m` is written
  /// into the weights' grid: LoadedVolume::view_sigma_m(). Errors: kOutput.
  [[nodiscard]] Result<void> save(const std::filesystem::path& path,
                                  std::optional<double> view_sigma_m = std::nullopt) const;

  // For what changes a volume block by block: integrate() and the like. The types are the library's own.

  [[nodiscard]] const BlockIndex& index() const { return *index_; }
  [[nodiscard]] BlockIndex& index() { return *index_; }
  [[nodiscard]] const VolumeMemory& memory() const { return *memory_; }
  /// The budget for new blocks, within fusion.memory_budget.
  [[nodiscard]] BlockBudget block_budget() const;
  /// Adds a block with leaves at a place without one. The volume takes the leaves.
  void add_block(NewBlock added);
  /// Removes the blocks of all regions but these (RegionSet). The others keep their leaves.
  void keep_only(const std::unordered_set<openvdb::Coord>& regions);
  /// Counts the memory for the colours of a block that had none before. Several threads may call this at once.
  void count_colours_of_a_block();
  /// The origins of the blocks that changed since the last call, so that only these are meshed again.
  [[nodiscard]] std::vector<openvdb::Coord> take_changed_blocks();

 private:
  TsdfVolume();
  FusionConfig config_;
  openvdb::FloatGrid::Ptr tsdf_;
  WeightCodeGrid::Ptr weight_;
  ColourCodeGrid::Ptr colour_;
  std::unique_ptr<BlockIndex> index_;
  std::unique_ptr<VolumeMemory> memory_;
};

/// A volume from a .vdb file of ScanKnit, or from any other with a FloatGrid.
struct LoadedVolume {
  openvdb::FloatGrid::Ptr field;    ///< "tsdf" if there is one, else the only (or first) FloatGrid
  openvdb::FloatGrid::Ptr weight;   ///< "weight" or null
  openvdb::Vec3SGrid::Ptr colour;   ///< "colour" or null
  bool is_signed_distance = false;  ///< a file of ScanKnit, or a grid of class level set

  /// A view for extract_surface() and others that read the volume, which keeps its grids.
  [[nodiscard]] FieldView field_view() const;
  /// The standard deviation of a view of weight 1, metres, > 0; nothing when the file does not say it.
  [[nodiscard]] std::optional<double> view_sigma_m() const;
};

/// Reads the file twice: first in a child process, which may use no more memory and time than a sound file of this size
/// can need, because OpenVDB believes all counts in a file. Errors (kInput): the file does not exist, is no VDB file,
/// is damaged, or has no FloatGrid (the message lists its grids); kBudget: the system has no child process.
[[nodiscard]] Result<LoadedVolume> load_volume(const std::filesystem::path& path);

}  // namespace scanknit
