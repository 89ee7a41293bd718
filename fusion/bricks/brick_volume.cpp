#include "fusion/bricks/brick_volume.h"

#include <utility>

namespace scanknit {

Result<void> BrickVolume::add(const std::filesystem::path& path, std::uint64_t job) {
  auto file = BrickFile::open(path, job);
  if (!file) return file.error();
  for (const BrickLayer& layer : file->layers()) layers_[layer.x] += layer.blocks;
  files_.push_back(*std::move(file));
  return {};
}

Result<TsdfVolume> BrickVolume::read(int begin_x, int end_x) const {
  auto volume = TsdfVolume::create(config_);
  if (!volume) return volume;
  for (const BrickFile& file : files_) {
    for (const BrickLayer& layer : file.layers()) {
      if (layer.x < begin_x || layer.x >= end_x) continue;
      if (auto read = file.read(layer, *volume); !read) return read.error();
    }
  }
  return volume;
}

}  // namespace scanknit
