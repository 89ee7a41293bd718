// Volumes that come as a file for each slice. Both functions are in the module: call them by volume_files.h.
#pragma once

#include <memory>

#include "extract/volume/slice_reader.h"

namespace scanknit {

/// A folder of PNG or TIFF slices. Errors: kUsage (no spacing), kInput, kBudget.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_image_stack(const std::filesystem::path& folder,
                                                                    const VolumeOptions& options);

/// The DICOM series that `path` belongs to, or the largest of the folder `path`. Errors: kInput, kBudget.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_dicom_series(const std::filesystem::path& path,
                                                                     const VolumeOptions& options);

}  // namespace scanknit
