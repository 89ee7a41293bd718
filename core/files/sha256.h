// SHA-256: a name for bytes that is the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace scanknit {

using Sha256 = std::array<std::uint8_t, 32>;

/// The hash of FIPS 180-4 (NIST 2015), section 6.2.
[[nodiscard]] Sha256 sha256(std::string_view bytes);

}  // namespace scanknit
