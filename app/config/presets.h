// The configurations of configs/, built into the program so that it works wherever it is installed.
#pragma once

#include <span>
#include <string_view>

namespace scanknit {

struct Preset {
  std::string_view name;  ///< "object": the file's name without .yaml
  std::string_view text;  ///< the file
};

/// In alphabetical order.
[[nodiscard]] std::span<const Preset> presets();

/// Null when there is none of that name.
[[nodiscard]] const Preset* find_preset(std::string_view name);

}  // namespace scanknit
