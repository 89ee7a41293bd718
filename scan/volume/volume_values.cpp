#include "scan/volume/volume_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/files/quantity.h"

namespace scanknit {

ValueSource values_of(const openvdb::FloatGrid& grid) {
  return [&grid](const auto& take) -> Result<void> {
    using Leaf = openvdb::FloatGrid::TreeType::LeafNodeType;
    std::vector<float> values;
    const auto hand_over = [&] {
      take(values);
      values.clear();
    };
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
      for (auto value = leaf->cbeginValueOn(); value; ++value) values.push_back(*value);
      hand_over();
    }
    auto tile = grid.tree().cbeginValueOn();
    tile.setMaxDepth(openvdb::FloatGrid::TreeType::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
      values.assign(Leaf::SIZE, *tile);
      hand_over();
    }
    return {};
  };
}

ValueSource values_of(SliceReader& reader) {
  return [&reader](const auto& take) -> Result<void> {
    const Eigen::Vector3i& dims = reader.header().dims;
    std::vector<float> slice(static_cast<std::size_t>(dims.x()) * static_cast<std::size_t>(dims.y()));
    for (int k = 0; k < dims.z(); ++k) {
      if (auto read = reader.read_slice(k, slice); !read) return read;
      take(slice);
    }
    return {};
  };
}

ValueSource values_of(const DenseVolume& volume) {
  return [&volume](const auto& take) -> Result<void> {
    take(volume.samples);
    return {};
  };
}

Result<ValueCensus> take_census(const ValueSource& values) {
  ValueCensus census;
  if (auto read = values([&](std::span<const float> piece) { census.add(piece); }); !read) return read.error();
  return census;
}

std::string range_text(const ValueCensus& census) {
  return fmt::format("from {} to {}", format_number(census.min()), format_number(census.max()));
}

}  // namespace scanknit
