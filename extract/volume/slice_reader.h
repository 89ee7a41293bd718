// SliceReader: a volume's file, read slice by slice. open_volume chooses the format.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "core/result.h"
#include "extract/extract_config.h"
#include "extract/volume/dense_volume.h"
#include "extract/volume/volume_header.h"

namespace scanknit {

/// Not for several threads at once.
class SliceReader {
 public:
  virtual ~SliceReader() = default;

  [[nodiscard]] virtual const VolumeHeader& header() const = 0;
  /// Fills `samples`, dims.x() * dims.y() of them, i fastest, with slice 0 <= k < dims.z(), in any order of k. NaN
  /// where nothing is known, never infinite. Errors (kInput): the file cannot be read, or changed since it was opened.
  [[nodiscard]] virtual Result<void> read_slice(int k, std::span<float> samples) = 0;
  /// False: the format can only be decoded whole, and the reader holds the whole volume in memory.
  [[nodiscard]] virtual bool is_streamed() const = 0;
};

/// Opens, by content and name: a folder of DICOM slices or one file in it (series by UID, the largest is taken; slices
/// sorted along the normal); a folder of PNG or TIFF slices (natural order of names; grey, or the luminance of colour;
/// needs options.spacing; no TIFF of several pages); NRRD (.nrrd, .nhdr); MetaImage (.mha, .mhd); NIfTI-1 (.nii, .hdr
/// and .img, with or without .gz); any other file as raw samples where options.dims, type and spacing are all given.
/// Streamed: DICOM, image stacks, raw files, and NRRD, MetaImage and NIfTI that are neither compressed nor text; these
/// are decoded whole, to the check sum at their end, else kBudget. Their samples are in one file: no lists of files.
/// Every size is checked against the file and the budget before memory is asked for. Rescale slopes are applied.
/// Not for several threads at once: ITK's libraries, which read these three headers, keep global state.
/// Errors: kInput (unreadable, truncated, not a volume of one number per sample, fewer than 2 samples along an axis),
/// kUsage (an option is missing, or does not belong to the format), kBudget.
[[nodiscard]] Result<std::unique_ptr<SliceReader>> open_volume(const std::filesystem::path& path,
                                                               const VolumeOptions& options);

/// The whole volume. kBudget: its floats would need more than `memory_budget_bytes`; else the errors of read_slice.
[[nodiscard]] Result<DenseVolume> read_volume(SliceReader& reader,
                                              std::size_t memory_budget_bytes = kDefaultVolumeBudget);

}  // namespace scanknit
