// Shows the user the links of the live view.
#pragma once

#include <string>
#include <vector>

#include "app/terminal/console.h"

namespace scanknit {

/// Prints the links and, on a terminal that is wide enough, a QR code of the first link that a phone can reach.
void announce(const std::vector<std::string>& links, Console& console);

}  // namespace scanknit
