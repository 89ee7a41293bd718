// Formats numbers and texts for report.html.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "core/image.h"

namespace scanknit {

/// Escapes text, also for an attribute's value, in HTML. Control characters become the replacement character; a text
/// longer than any of ours ends in "...".
[[nodiscard]] std::string escaped(std::string_view text);

[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// "1,234,567"
[[nodiscard]] std::string grouped_digits(double count);
/// "12.3 mm", "1.20 m": three significant digits.
[[nodiscard]] std::string length_words(double metres);
/// A figure of a finishing step, formatted by the unit at the end of its name: "area_removed_mm2" becomes "area removed
/// 693,027 mm2", "invented_share" "invented 12.1 %". Not escaped.
[[nodiscard]] std::string figure_words(std::string_view name, double value);
/// "0.85 s", "2 min 5 s"
[[nodiscard]] std::string time_words(double milliseconds);
/// "97 %"
[[nodiscard]] std::string percent(double share);
/// "#rrggbb"
[[nodiscard]] std::string css_colour(Rgb8 colour);

}  // namespace scanknit
