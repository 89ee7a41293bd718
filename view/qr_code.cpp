#include "view/qr_code.h"

#include <exception>
#include <qrcodegen/qrcodegen.hpp>

namespace scanknit {
namespace {

constexpr int kQuietZone = 2;  // the standard asks for 4; phones read 2, which leaves room in a terminal of 80 columns
constexpr const char* kBlackOnWhite = "\x1b[30;107m";
constexpr const char* kEnd = "\x1b[0m";

}  // namespace

std::string qr_code(std::string_view text, int columns) {
  try {
    const auto code = qrcodegen::QrCode::encodeText(std::string(text).c_str(), qrcodegen::QrCode::Ecc::LOW);
    const int size = code.getSize();
    if (size + 2 * kQuietZone > columns) return "";
    std::string lines;
    for (int y = -kQuietZone; y < size + kQuietZone; y += 2) {
      lines += kBlackOnWhite;
      for (int x = -kQuietZone; x < size + kQuietZone; ++x) {
        const bool is_upper = code.getModule(x, y);  // light outside of the code
        const bool is_lower = code.getModule(x, y + 1);
        lines += is_upper ? (is_lower ? "\u2588" : "\u2580") : (is_lower ? "\u2584" : " ");
      }
      lines += kEnd;
      lines += '\n';
    }
    return lines;
  } catch (const std::exception&) {
    return "";
  }
}

}  // namespace scanknit
