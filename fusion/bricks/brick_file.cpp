#include "fusion/bricks/brick_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/files/atomic_file.h"
#include "core/files/byte_reader.h"
#include "core/files/crc32.h"
#include "core/files/little_endian.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using Mask = TsdfLeaf::NodeMaskType;

constexpr std::string_view kBrickMagic = "SKBRICK2";
constexpr std::size_t kMaskWords = 8;
constexpr unsigned kHasColours = 1, kIsFree = 2;
constexpr std::size_t kLayerEntryBytes = 4 + 4 + 4 + 8 + 8;
constexpr std::size_t kTailBytes = 8 + 8 + 4 + kBrickMagic.size();

std::uint32_t checksum_of(std::string_view bytes) {
  return crc32(std::as_bytes(std::span(bytes)));
}

void append_block(std::string& bytes, const VolumeBlock& block) {
  append_little_endian(bytes, block.origin.y());
  append_little_endian(bytes, block.origin.z());
  for (std::size_t i = 0; i < kMaskWords; ++i) {
    append_little_endian(bytes, block.tsdf->getValueMask().getWord<std::uint64_t>(static_cast<openvdb::Index>(i)));
  }
  const float* const tsdf = block.tsdf->buffer().data();
  const WeightCode* const weight = block.weight->buffer().data();
  for (std::size_t i = 0; i < kBlockVoxels; ++i) append_little_endian(bytes, tsdf[i]);
  for (std::size_t i = 0; i < kBlockVoxels; ++i) append_little_endian(bytes, weight[i]);
  const bool has_colours = has_own_colours(*block.colour);
  append_little_endian(bytes,
                       static_cast<std::uint8_t>((has_colours ? kHasColours : 0) | (block.is_free ? kIsFree : 0)));
  if (!has_colours) return;
  const ColourCode* const colour = colours_of(*block.colour);
  for (std::size_t i = 0; i < kBlockVoxels; ++i) append_little_endian(bytes, colour[i].bits);
}

std::string table_and_tail(const std::vector<BrickLayer>& layers, std::uint64_t job) {
  std::string bytes;
  for (const BrickLayer& layer : layers) {
    append_little_endian(bytes, layer.x);
    append_little_endian(bytes, layer.blocks);
    append_little_endian(bytes, layer.checksum);
    append_little_endian(bytes, layer.offset);
    append_little_endian(bytes, layer.bytes);
  }
  append_little_endian(bytes, static_cast<std::uint64_t>(bytes.size()));
  append_little_endian(bytes, job);
  append_little_endian(bytes, checksum_of(bytes));
  return bytes.append(kBrickMagic);
}

/// All but the end, which makes the file one with a name.
Result<AtomicFile> write_blocks(std::vector<const VolumeBlock*> blocks, std::uint64_t job,
                                const std::filesystem::path& path) {
  std::sort(blocks.begin(), blocks.end(), [](const auto* a, const auto* b) { return a->origin < b->origin; });
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto begun = file->write(kBrickMagic); !begun) return begun.error();
  std::vector<BrickLayer> layers;
  std::uint64_t offset = kBrickMagic.size();
  for (auto begin = blocks.begin(); begin != blocks.end();) {
    const int x = (*begin)->origin.x();
    const auto end = std::find_if(begin, blocks.end(), [&](const auto* block) { return block->origin.x() != x; });
    std::string bytes;
    std::for_each(begin, end, [&](const auto* block) { append_block(bytes, *block); });
    if (auto written = file->write(bytes); !written) return written.error();
    layers.push_back({x, static_cast<std::uint32_t>(end - begin), checksum_of(bytes), offset, bytes.size()});
    offset += bytes.size();
    begin = end;
  }
  if (auto ended = file->write(table_and_tail(layers, job)); !ended) return ended.error();
  return file;
}

/// Reads parts of a file.
class PartsOfFile {
 public:
  explicit PartsOfFile(const std::filesystem::path& path) : file_(path, std::ios::binary | std::ios::ate) {
    if (file_) size_ = static_cast<std::uint64_t>(file_.tellg());
  }
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// Nothing if the file does not have these bytes.
  [[nodiscard]] std::optional<std::vector<std::byte>> read(std::uint64_t offset, std::uint64_t count) {
    if (offset > size_ || count > size_ - offset) return std::nullopt;
    std::vector<std::byte> bytes(static_cast<std::size_t>(count));
    file_.seekg(static_cast<std::streamoff>(offset));
    file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
    if (file_.gcount() != static_cast<std::streamsize>(count)) return std::nullopt;
    return bytes;
  }

 private:
  std::ifstream file_;
  std::uint64_t size_ = 0;
};

Error damaged_brick(const std::filesystem::path& path, const char* what) {
  return {ErrorCode::kInput, std::string(what) + "; run the scan again", path.string()};
}

bool is_magic(std::span<const std::byte> bytes) {
  return std::ranges::equal(bytes, std::as_bytes(std::span(kBrickMagic)));
}

/// Nothing if the table does not fill its bytes, or is not in order.
std::optional<std::vector<BrickLayer>> parse_table(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  std::vector<BrickLayer> layers;
  while (reader.remaining() >= kLayerEntryBytes) {
    BrickLayer layer;
    layer.x = *reader.little_endian<std::int32_t>();
    layer.blocks = *reader.little_endian<std::uint32_t>();
    layer.checksum = *reader.little_endian<std::uint32_t>();
    layer.offset = *reader.little_endian<std::uint64_t>();
    layer.bytes = *reader.little_endian<std::uint64_t>();
    if (layer.x % kBlockEdgeVoxels != 0 || (!layers.empty() && layer.x <= layers.back().x)) return std::nullopt;
    layers.push_back(layer);
  }
  if (reader.remaining() > 0) return std::nullopt;
  return layers;
}

template <typename T>
bool read_all(ByteReader& reader, std::span<T> values) {
  for (T& value : values) {
    const auto read = reader.little_endian<T>();
    if (!read) return false;
    value = *read;
  }
  return true;
}

bool read_colours(ByteReader& reader, ColourLeaf& leaf) {
  std::array<std::uint32_t, kBlockVoxels> codes;
  if (!read_all<std::uint32_t>(reader, codes)) return false;
  ColourCode* const colours = leaf.buffer().data();
  for (std::size_t i = 0; i < kBlockVoxels; ++i) colours[i].bits = codes[i];
  return true;
}

/// Nothing if the bytes are no block of the layer at `x`.
std::optional<NewBlock> read_block(ByteReader& reader, int x, float background_m) {
  std::array<std::int32_t, 2> at;
  std::array<std::uint64_t, kMaskWords> words;
  if (!read_all<std::int32_t>(reader, at) || !read_all<std::uint64_t>(reader, words)) return std::nullopt;
  if (at[0] % kBlockEdgeVoxels != 0 || at[1] % kBlockEdgeVoxels != 0) return std::nullopt;
  NewBlock block(Coord(x, at[0], at[1]), background_m);
  const std::span<float> tsdf(block.tsdf->buffer().data(), kBlockVoxels);
  const std::span<WeightCode> weight(block.weight->buffer().data(), kBlockVoxels);
  if (!read_all(reader, tsdf) || !read_all(reader, weight)) return std::nullopt;
  Mask observed;
  for (std::size_t i = 0; i < kMaskWords; ++i) {
    observed.getWord<std::uint64_t>(static_cast<openvdb::Index>(i)) = words[i];
  }
  block.tsdf->setValueMask(observed);
  block.weight->setValueMask(observed);
  block.colour->setValueMask(observed);
  const auto flags = reader.little_endian<std::uint8_t>();
  if (!flags || *flags > (kHasColours | kIsFree)) return std::nullopt;
  block.block.is_free = (*flags & kIsFree) != 0;
  if ((*flags & kHasColours) != 0 && !read_colours(reader, *block.colour)) return std::nullopt;
  return block;
}

}  // namespace

Result<void> write_brick_file(const TsdfVolume& volume, std::uint64_t job, const std::filesystem::path& path,
                              const RegionSet* part) {
  std::vector<const VolumeBlock*> blocks;
  for (const VolumeBlock& block : volume.index().blocks()) {
    if (part == nullptr || part->contains(region_of(block.origin))) blocks.push_back(&block);
  }
  auto file = write_blocks(std::move(blocks), job, path);
  return file ? file->commit() : file.error();
}

Result<void> write_page(std::vector<const VolumeBlock*> blocks, std::uint64_t job, const std::filesystem::path& path) {
  auto file = write_blocks(std::move(blocks), job, path);
  return file ? file->commit_without_sync() : file.error();
}

Result<BrickFile> BrickFile::open(const std::filesystem::path& path, std::uint64_t job) {
  PartsOfFile file(path);
  const auto magic = file.read(0, kBrickMagic.size());
  if (!magic || !is_magic(*magic)) return damaged_brick(path, "is no brick file");
  if (file.size() < kBrickMagic.size() + kTailBytes) return damaged_brick(path, "is cut off");
  const std::uint64_t before_tail = file.size() - kTailBytes;
  const auto tail = file.read(before_tail, kTailBytes);
  if (!tail || !is_magic(std::span(*tail).last(kBrickMagic.size()))) return damaged_brick(path, "is cut off");
  ByteReader reader(*tail);
  const auto table_bytes = *reader.little_endian<std::uint64_t>();
  const auto job_of_file = *reader.little_endian<std::uint64_t>();
  const auto checksum = *reader.little_endian<std::uint32_t>();
  if (table_bytes > before_tail - kBrickMagic.size()) return damaged_brick(path, "has a damaged table");
  const std::uint64_t begin = before_tail - table_bytes;
  const auto table = file.read(begin, table_bytes + 2 * sizeof(std::uint64_t));
  if (!table || crc32(*table) != checksum) return damaged_brick(path, "has a damaged table");
  auto layers = parse_table(std::span(*table).first(static_cast<std::size_t>(table_bytes)));
  if (!layers) return damaged_brick(path, "has a damaged table");
  if (job_of_file != job) return damaged_brick(path, "belongs to another scan, or to other settings");
  return BrickFile(path, *std::move(layers));
}

bool BrickFile::is_whole() const {
  PartsOfFile file(path_);
  return std::all_of(layers_.begin(), layers_.end(), [&](const BrickLayer& layer) {
    const auto bytes = file.read(layer.offset, layer.bytes);
    return bytes && crc32(*bytes) == layer.checksum;
  });
}

Result<void> BrickFile::read(const BrickLayer& layer, TsdfVolume& volume) const {
  const auto bytes = PartsOfFile(path_).read(layer.offset, layer.bytes);
  if (!bytes || crc32(*bytes) != layer.checksum) return damaged_brick(path_, "has a damaged layer");
  ByteReader reader(*bytes);
  for (std::uint32_t i = 0; i < layer.blocks; ++i) {
    auto block = read_block(reader, layer.x, volume.tsdf().background());
    if (!block) return damaged_brick(path_, "has a damaged block");
    if (volume.index().find(block->block.origin) != BlockIndex::kNone) {
      return damaged_brick(path_, "has a block that another file has, too");
    }
    volume.add_block(*std::move(block));
  }
  if (reader.remaining() > 0) return damaged_brick(path_, "has a damaged layer");
  return {};
}

}  // namespace scanknit
