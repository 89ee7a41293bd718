// The headers of NRRD, MetaImage and NIfTI-1, read by ITK's own libraries for them: teem's NrrdIO, MetaIO and niftilib.
// One level below itk::ImageIOBase, which loses what a file says: NRRD's space and units, NIfTI's sform, the data's
// place. Neither samples nor memory for them are asked of these libraries. All are in the module: call them by
// volume_files.h.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "core/result.h"
#include "extract/volume/file_layout.h"

namespace scanknit {

// All return kInput for a header that is truncated, malformed, or of something else than a volume of one number per
// sample. Axes of a single sample beyond the third dimension are dropped. What checked_bytes checks is left to it.
// The libraries keep global state: not for several threads at once.

/// NRRD, attached or detached: teem.sourceforge.net/nrrd/format.html. `path` is a regular file.
[[nodiscard]] Result<FileLayout> read_nrrd_header(const std::filesystem::path& path);

/// MetaImage, .mha or .mhd: ITK's MetaIO documentation. `path` is a regular file.
[[nodiscard]] Result<FileLayout> read_meta_header(const std::filesystem::path& path);

inline constexpr std::size_t kNiftiHeaderBytes = 348;

/// NIfTI-1, the file's first kNiftiHeaderBytes, not compressed: nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h.
/// T_file_index is the sform where it has a code, else the qform where it has one, else the spacing. data_file stays
/// empty also for a pair. `path` is for messages only.
[[nodiscard]] Result<FileLayout> read_nifti_header(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace scanknit
