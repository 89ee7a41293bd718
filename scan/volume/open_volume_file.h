// Opening a volume's file as the program's options ask for it.
#pragma once

#include <filesystem>
#include <memory>

#include "core/result.h"
#include "extract/extract_config.h"
#include "extract/volume/slice_reader.h"

namespace scanknit {

/// Adds the program's names of options to a reader's error: the readers do not know them.
[[nodiscard]] Error naming_options(Error error, const std::filesystem::path& path);

/// open_volume() within extract.memory_budget; its errors name the program's options.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_volume_file(const std::filesystem::path& path,
                                                                    VolumeOptions options, const ExtractConfig& config);

/// True when the file's name ends in .vdb.
[[nodiscard]] bool is_vdb(const std::filesystem::path& path);

/// kUsage when an option is set that does not apply to OpenVDB files.
[[nodiscard]] Result<void> refuse_options_for_vdb(const std::filesystem::path& path, const VolumeOptions& options);

}  // namespace scanknit
