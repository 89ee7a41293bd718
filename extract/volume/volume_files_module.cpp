// The module libscanknit_volume_files.so.
#include "core/version.h"
#include "extract/volume/itk_headers.h"
#include "extract/volume/slice_files.h"
#include "extract/volume/volume_files.h"

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr VolumeFiles kOffers{read_nrrd_header, read_meta_header, read_nifti_header, open_image_stack,
                                       open_dicom_series};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
