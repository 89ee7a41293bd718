// The configurations of configs/, built into the program so that it needs no files where it is installed.
#pragma once

#include <span>
#include <string_view>

namespace scanknit {

struct Preset {
  std::string_view name;  ///< the file's name without .yaml: "object"
  std::string_view text;  ///< the file's text
};

/// In alphabetical order.
[[nodiscard]] std::span<const Preset> presets();

/// Null if there is no preset with that name.
[[nodiscard]] const Preset* find_preset(std::string_view name);

}  // namespace scanknit
