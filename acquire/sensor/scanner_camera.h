// What acquire.camera states, in the place of what a scanner or recording says of itself.
#pragma once

#include <span>
#include <string>

#include "acquire/raw_frame.h"
#include "core/result.h"

namespace scanknit {

/// Errors (kConfig): both `camera` and `intrinsics` state the depth camera; a camera without a size or with numbers
/// that are none; a depth bias that is not is_valid().
[[nodiscard]] Result<void> check_cameras(const AcquireConfig& config);

/// For pairs of pictures, whose two cameras `who` states: the scanner, or a file. Error (kConfig): `config` states a
/// camera as well.
[[nodiscard]] Result<void> refuse_other_cameras(const AcquireConfig& config, const std::string& who);

/// Error (kConfig): `camera` belongs to a scanner with another serial number. Unknown ones fit.
[[nodiscard]] Result<void> check_serial(const ScannerCamera& camera, const std::string& serial);

/// Puts what `camera` states in the place of a scanner's own calibration. Errors (kConfig): check_serial()'s; it is for
/// pictures of another size than those of `streams`.
[[nodiscard]] Result<void> override_calibration(const ScannerCamera& camera, std::span<const StreamProfile> streams,
                                                RawCalibration& calibration);

}  // namespace scanknit
