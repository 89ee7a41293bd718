// Warnings of scans, priors and poses that make a result of `align` doubtful.
#pragma once

#include <string>
#include <vector>

#include "scan/align/align_inputs.h"

namespace scanknit {

/// Warns of scans that are larger than a building, and of scans whose sizes differ as much as millimetres and metres
/// do: the unit of one may be wrong.
[[nodiscard]] std::vector<std::string> unit_warnings(const AlignInputs& inputs);

/// Warns of pairs that do not fit at the poses of the files, and of scans whose pose no other scan confirms.
[[nodiscard]] std::vector<std::string> given_pose_warnings(const AlignInputs& inputs, const Alignment& alignment);

/// Warns of priors that are more than a tenth of the scans' size from the poses that fit, or from each other.
[[nodiscard]] std::vector<std::string> prior_warnings(const AlignInputs& inputs, const AlignPriors& priors,
                                                      const Alignment& alignment);

}  // namespace scanknit
