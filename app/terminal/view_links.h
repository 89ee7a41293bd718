// How a person gets to the live view.
#pragma once

#include <string>
#include <vector>

#include "app/terminal/console.h"

namespace scanknit {

/// Prints the links and, on a terminal that is wide enough, the first that a phone can reach as a QR code.
void announce(const std::vector<std::string>& links, Console& console);

}  // namespace scanknit
