// Pictures within report.html.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace scanknit {

/// A PNG file as a JPEG of at most `most_columns`, as a data URI; empty when it is no PNG, or a huge one.
[[nodiscard]] std::string picture_uri(std::span<const std::byte> png, int most_columns);

}  // namespace scanknit
