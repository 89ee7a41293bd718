#include "export/report/page_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scanknit {
namespace {

constexpr std::size_t kMostBytes = 600;  // of one text: a path may have 4096, a page of a phone shows some 40 a line

}  // namespace

std::string escaped(std::string_view text) {
  std::string html;
  const bool is_cut = text.size() > kMostBytes;
  if (is_cut) {
    std::size_t end = kMostBytes;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a character
    text = text.substr(0, end);
  }
  for (const char c : text) {
    switch (c) {
      case '&': html += "&amp;"; break;
      case '<': html += "&lt;"; break;
      case '>': html += "&gt;"; break;
      case '"': html += "&quot;"; break;
      case '\'': html += "&#39;"; break;
      case '\n': html += c; break;
      default:
        const auto code = static_cast<unsigned char>(c);
        if (code < 0x20 || code == 0x7F) {
          html += "\xEF\xBF\xBD";
        } else {
          html += c;
        }
    }
  }
  return is_cut ? html + "..." : html;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t have = std::min<std::size_t>(3, bytes.size() - i);
    unsigned value = 0;
    for (std::size_t k = 0; k < 3; ++k) value = value << 8 | (k < have ? std::to_integer<unsigned>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= have ? kDigits[value >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string grouped_digits(double count) {
  const std::string digits = fmt::format("{:.0f}", std::abs(count));
  std::string grouped = count <= -0.5 ? "-" : "";
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) grouped += ',';
    grouped += digits[i];
  }
  return grouped;
}

std::string length_words(double metres) {
  if (std::abs(metres) >= 1) return fmt::format("{:.2f} m", metres);
  const double millimetres = metres * 1000;
  const int decimals = std::abs(millimetres) >= 100 ? 0 : std::abs(millimetres) >= 10 ? 1 : 2;
  return fmt::format("{:.{}f} mm", millimetres, decimals);
}

std::string figure_words(std::string_view name, double value) {
  // Three digits, or all of those before the point.
  const auto rounded = [](double number) {
    const double size = std::abs(number);
    if (size >= 99.95) return grouped_digits(number);
    return size < 0.0005 ? std::string("0") : fmt::format("{:.3g}", number);
  };
  struct Unit {
    std::string_view ending, words;
    double factor;
  };
  constexpr std::array kUnits = {Unit{"_mm2", " mm2", 1}, Unit{"_mm", " mm", 1}, Unit{"_degrees", " degrees", 1},
                                 Unit{"_share", " %", 100}};
  const auto unit =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& one) { return name.ends_with(one.ending); });
  const Unit known = unit == kUnits.end() ? Unit{"", "", 1} : *unit;  // a count
  std::string words(name.substr(0, name.size() - known.ending.size()));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words + " " + rounded(known.factor * value) + std::string(known.words);
}

std::string time_words(double milliseconds) {
  const double seconds = milliseconds / 1000;
  if (seconds < 120) return fmt::format("{:.2f} s", seconds);
  return fmt::format("{:.0f} min {:.0f} s", std::floor(seconds / 60), std::floor(std::fmod(seconds, 60)));
}

std::string percent(double share) {
  return fmt::format("{:.0f} %", 100 * share);
}

std::string css_colour(Rgb8 colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b);
}

}  // namespace scanknit
