#include "scan/volume/vdb_grids.h"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <exception>
#include <new>

namespace scanknit {

std::vector<std::string> other_float_grids(const std::filesystem::path& path, const LoadedVolume& volume) {
  std::vector<std::string> names;
  try {
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(/*delayLoad=*/false);  // else OpenVDB makes a temporary copy, which it leaves if it fails
    const openvdb::GridPtrVecPtr grids = file.readAllGridMetadata();
    for (const openvdb::GridBase::Ptr& grid : *grids) {
      if (grid->isType<openvdb::FloatGrid>()) names.push_back(grid->getName());
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return {};
  }
  for (const auto& taken : {volume.field, volume.weight}) {
    if (!taken) continue;
    // Removes one entry only: several grids may have the same name.
    const auto place = std::ranges::find(names, taken->getName());
    if (place != names.end()) names.erase(place);
  }
  return names;
}

}  // namespace scanknit
