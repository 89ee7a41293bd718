#include "app/live/tracking_advice.h"

#include <array>
#include <utility>

namespace scanknit {

std::string tracking_advice(std::string_view reason) {
  using Advice = std::pair<std::string_view, std::string_view>;
  static constexpr std::array kAdvice = {
      Advice{"nothing seen", "uncover the lens, or move closer"},
      Advice{"too close", "step back a little"},
      Advice{"too few points", "show more of the object or the room"},
      Advice{"too fast", "go back a little, and move more slowly"},
      Advice{"place not recognised", "show something that was scanned before"},
      Advice{"making sure", "hold still for a moment"},
      Advice{"flat scene", "let something with edges or a pattern into view"},
      Advice{"scene is changing", "wait until nothing moves"},
      Advice{"scene has changed", "wait until nothing moves"},
      Advice{"little overlap", "move more slowly"},
      Advice{"recorded pose kept", "what is seen here cannot improve it"},
      Advice{"recorded pose does not fit", "frames like this are left out"},
  };
  for (const auto& [known, advice] : kAdvice) {
    if (known == reason) return std::string(advice);
  }
  return "";
}

}  // namespace scanknit
