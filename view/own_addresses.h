// The addresses by which other computers reach this one.
#pragma once

#include <string>
#include <vector>

namespace scanknit {

/// Numeric, of all network interfaces but the loopback.
[[nodiscard]] std::vector<std::string> own_addresses(bool is_v6);

}  // namespace scanknit
