#include "scan/volume/open_volume_file.h"
#include "core/files/lower_extension.h"

#include <algorithm>
#include <string>
#include <utility>

namespace scanknit {

Error naming_options(Error error, const std::filesystem::path& path) {
  if (error.code == ErrorCode::kUsage) error.message += " (see dims, type and spacing)";
  if (error.code == ErrorCode::kBudget) error.message += " (extract.memory_budget=SIZE)";
  if (error.where.empty()) error.where = path.string();
  return error;
}

Result<std::unique_ptr<SliceReader>> open_volume_file(const std::filesystem::path& path, VolumeOptions options,
                                                      const ExtractConfig& config) {
  options.memory_budget_bytes = static_cast<std::size_t>(config.memory_budget_mib) << 20;
  auto reader = open_volume(path, options);
  if (!reader) return naming_options(reader.error(), path);
  return reader;
}

bool is_vdb(const std::filesystem::path& path) {
  return lower_extension(path) == ".vdb";
}

Result<void> refuse_options_for_vdb(const std::filesystem::path& path, const VolumeOptions& options) {
  if (!options.dims && !options.type && !options.spacing) return {};
  return Error{ErrorCode::kUsage, "dims, type and spacing are for raw samples and stacks of images, not for .vdb",
               path.string()};
}

}  // namespace scanknit
