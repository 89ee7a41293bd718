// report.html of `distance`: how far a mesh deviates, on one page.
#pragma once

#include <string>

#include "app/measure/deviation_text.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// One file without scripts or other files: the tolerance, the picture, the histogram (SVG), and tables of vertices and
/// areas and of the parts of the reference's box. Error (kOutput): the picture cannot be packed.
[[nodiscard]] Result<std::string> deviation_page(const Comparison& comparison, const ColourImage& picture,
                                                 const std::string& histogram);

}  // namespace scanknit
