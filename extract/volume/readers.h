// The readers behind open_volume that need no module: samples in one file.
#pragma once

#include <memory>

#include "extract/volume/file_layout.h"
#include "extract/volume/slice_reader.h"

namespace scanknit {

/// The samples as the layout says, uncompressed, in `data_path`: streamed. Errors (kInput): the file is missing or
/// shorter than the layout; kBudget: a slice exceeds the budget.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_raw_samples(const std::filesystem::path& data_path,
                                                                    FileLayout layout, std::size_t budget_bytes);

/// Deflated (zlib or gzip) or text samples in `data_path`, decoded whole. Errors: kInput, kBudget.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_encoded_samples(const std::filesystem::path& data_path,
                                                                        FileLayout layout, std::size_t budget_bytes);

/// A PNG or TIFF, by its ending.
[[nodiscard]] bool has_image_name(const std::filesystem::path& path);

}  // namespace scanknit
