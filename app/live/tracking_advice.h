// What a person can do about tracking.
#pragma once

#include <string>
#include <string_view>

namespace scanknit {

/// A sentence for one of the reasons of docs/report.md; empty where there is nothing to do.
[[nodiscard]] std::string tracking_advice(std::string_view reason);

}  // namespace scanknit
