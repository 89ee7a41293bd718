// What people should know of scans, priors and poses before they believe a result of `align`.
#pragma once

#include <string>
#include <vector>

#include "scan/align/align_inputs.h"

namespace scanknit {

/// Scans that are larger than a building, or of sizes a thousandfold apart: millimetres that are taken for metres.
[[nodiscard]] std::vector<std::string> unit_warnings(const AlignInputs& inputs);

/// Pairs that the files' poses put together wrongly, and scans whose place no other scan bears out.
[[nodiscard]] std::vector<std::string> given_pose_warnings(const AlignInputs& inputs, const Alignment& alignment);

/// Priors that are farther from what fits than a tenth of the scans' size, or contradict each other so far.
[[nodiscard]] std::vector<std::string> prior_warnings(const AlignInputs& inputs, const AlignPriors& priors,
                                                      const Alignment& alignment);

}  // namespace scanknit
