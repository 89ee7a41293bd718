// Draws a link as a QR code in the terminal.
#pragma once

#include <string>
#include <string_view>

namespace scanknit {

/// Lines of half blocks, dark on light, with a quiet zone. Empty when the text is too long for a code (2.9 KB), or the
/// code is wider than `columns`: wrapped lines cannot be read.
[[nodiscard]] std::string qr_code(std::string_view text, int columns);

}  // namespace scanknit
