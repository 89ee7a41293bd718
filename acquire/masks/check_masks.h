// Finds masks that are most likely not what was meant.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "acquire/masks/mask_files.h"

namespace scanknit {

/// A mask as its file has it.
struct MaskFile {
  std::filesystem::path path;
  Mask mask;
};

/// A message for each kind of fault, which names the first mask that has it: its sides have another ratio than those of
/// the depth picture; nothing is in it; all is in it; it is inverted, which is likely where three quarters of its
/// border are in it and three quarters of its middle are not.
[[nodiscard]] std::vector<std::string> mask_warnings(const std::vector<MaskFile>& masks, int depth_width,
                                                     int depth_height, const AcquireConfig& config);

}  // namespace scanknit
