// Brick files: the finished blocks of a part of a volume, on disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/result.h"
#include "fusion/volume/region_set.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// The blocks whose lowest voxels have the same x.
struct BrickLayer {
  int x = 0;  ///< index coordinate, a multiple of 8
  std::uint32_t blocks = 0;
  std::uint32_t checksum = 0;  ///< CRC-32 of its bytes
  std::uint64_t offset = 0;    ///< of its bytes in the file
  std::uint64_t bytes = 0;
};

/// Writes all blocks of `volume`, or only those of `part`, unless it is null; all or nothing. `job` says which scan
/// they belong to: open() must be given the same. Little-endian: "SKBRICK2"; the layers by x, each of them blocks by y
/// and z (two int32; the observed voxels, 64 bytes; 512 distances, 512 codes of weights; a byte: 1 if 512 codes of
/// colours follow, plus 2 if the block is known to be free); the table of layers; its length, the job and the CRC-32 of
/// the table and both; "SKBRICK2" again. Errors: kOutput.
[[nodiscard]] Result<void> write_brick_file(const TsdfVolume& volume, std::uint64_t job,
                                            const std::filesystem::path& path, const RegionSet* part = nullptr);

/// The same for these blocks, in a file that is of no use after this process.
[[nodiscard]] Result<void> write_page(std::vector<const VolumeBlock*> blocks, std::uint64_t job,
                                      const std::filesystem::path& path);

/// A brick file to read, layer by layer.
class BrickFile {
 public:
  /// Reads the table of layers. Errors (kInput): not a whole brick file, damaged, or of another job.
  [[nodiscard]] static Result<BrickFile> open(const std::filesystem::path& path, std::uint64_t job);

  /// By x.
  [[nodiscard]] std::span<const BrickLayer> layers() const { return layers_; }

  /// Reads all bytes. False: a layer is damaged, or cannot be read.
  [[nodiscard]] bool is_whole() const;

  /// Adds the blocks of one layer to `volume`, which has none of them. Errors (kInput): the layer is damaged, or cannot
  /// be read; the volume may have some of its blocks then.
  [[nodiscard]] Result<void> read(const BrickLayer& layer, TsdfVolume& volume) const;

 private:
  BrickFile(std::filesystem::path path, std::vector<BrickLayer> layers)
      : path_(std::move(path)), layers_(std::move(layers)) {}

  std::filesystem::path path_;
  std::vector<BrickLayer> layers_;
};

}  // namespace scanknit
