// Parses and formats quantities: numbers with a unit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace scanknit {

/// Parses `text` as one finite decimal number: "4", "-0.5", "1e-3". Nothing for any other text, also NaN and infinity.
[[nodiscard]] std::optional<double> parse_finite(std::string_view text);

struct Length {
  double metres = 0;
  bool has_unit = false;
};

/// "2mm", "0.4 cm", "3 m", or plain metres.
[[nodiscard]] std::optional<Length> parse_length(std::string_view text);

/// "512MiB", "2 GiB", or plain mebibytes. In mebibytes; at least 1 unless the text says 0.
[[nodiscard]] std::optional<std::int64_t> parse_memory_mib(std::string_view text);

/// The shortest text that parse_finite() turns back into the same bits.
[[nodiscard]] std::string format_number(double value);

/// "4 mm" below 10 cm, "3 m" from there on, "0" for zero: the text that parse_length() turns back into the same bits.
[[nodiscard]] std::string format_length(double metres);

/// "4 GiB" or "600 MiB".
[[nodiscard]] std::string format_memory_mib(std::int64_t mebibytes);

}  // namespace scanknit
