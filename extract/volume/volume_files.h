// The readers of volume files that bring other libraries with them (ITK, GDCM, OpenCV, and what those need): in a
// module, libscanknit_volume_files.so.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "core/system/module.h"
#include "extract/volume/file_layout.h"
#include "extract/volume/slice_reader.h"

namespace scanknit {

/// The functions of these names: itk_headers.h and slice_files.h say what they promise.
struct VolumeFiles {
  Result<FileLayout> (*read_nrrd_header)(const std::filesystem::path& path);
  Result<FileLayout> (*read_meta_header)(const std::filesystem::path& path);
  Result<FileLayout> (*read_nifti_header)(std::span<const std::byte> bytes, const std::filesystem::path& path);
  Result<std::unique_ptr<SliceReader>> (*open_image_stack)(const std::filesystem::path& folder,
                                                           const VolumeOptions& options);
  Result<std::unique_ptr<SliceReader>> (*open_dicom_series)(const std::filesystem::path& path,
                                                            const VolumeOptions& options);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const VolumeFiles*> load_volume_files() {
  return load_module<VolumeFiles>("volume_files",
                                  "Install scanknit again; it needs Debian's libinsighttoolkit5.2, libgdcm3.0 and "
                                  "libopencv-imgcodecs406");
}

}  // namespace scanknit
