// The skeleton of a DICOM file: whether its elements nest and end as they claim.
#pragma once

#include <cstddef>
#include <span>

namespace scanknit {

/// True for a file (DICOM PS3.10) whose elements, sequences and items all end within one another and the last at the
/// file's end, with pixels among them, in the transfer syntaxes of PS3.5 annex A but the deflated one. GDCM is built
/// with assertions: it aborts on files of which this is not true.
[[nodiscard]] bool is_dicom_structure(std::span<const std::byte> file);

}  // namespace scanknit
