// A link as a QR code in the terminal.
#pragma once

#include <string>
#include <string_view>

namespace scanknit {

/// Lines of half blocks, dark on light, with the quiet zone that readers ask for; empty where the text is too long for
/// a code (2.9 KB), or the code wider than `columns`: wrapped lines are no code.
[[nodiscard]] std::string qr_code(std::string_view text, int columns);

}  // namespace scanknit
