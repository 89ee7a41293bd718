// BrickVolume: a volume in brick files, of which a few layers are in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include "core/result.h"
#include "fusion/bricks/brick_file.h"
#include "fusion/fusion_config.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

class BrickVolume {
 public:
  /// `config`: of the volume that was fused.
  explicit BrickVolume(const FusionConfig& config) : config_(config) {}

  /// Adds the blocks of a file, which no other file has. Errors: those of BrickFile::open().
  [[nodiscard]] Result<void> add(const std::filesystem::path& path, std::uint64_t job);

  /// The number of blocks in each layer, by the x of its lowest voxels.
  [[nodiscard]] const std::map<int, std::size_t>& layers() const { return layers_; }

  /// A volume of the blocks with begin_x <= x < end_x, whatever memory they take. Errors: those of BrickFile::read().
  [[nodiscard]] Result<TsdfVolume> read(int begin_x, int end_x) const;

 private:
  FusionConfig config_;
  std::vector<BrickFile> files_;
  std::map<int, std::size_t> layers_;
};

}  // namespace scanknit
