// Advice for the user on tracking.
#pragma once

#include <string>
#include <string_view>

namespace scanknit {

/// Advice for one of the reasons of docs/report.md; empty when there is nothing to do.
[[nodiscard]] std::string tracking_advice(std::string_view reason);

}  // namespace scanknit
