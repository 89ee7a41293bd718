// The addresses by which other computers reach this one.
#pragma once

#include <string>
#include <vector>

namespace scanknit {

/// The numeric addresses of all network interfaces except the loopback.
[[nodiscard]] std::vector<std::string> own_addresses(bool is_v6);

}  // namespace scanknit
