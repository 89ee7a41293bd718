// "Did you mean ...?"
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace scanknit {

/// Single-character edits (insert, delete, replace, swap of neighbours) between two words: the optimal string alignment
/// distance (Damerau 1964, Levenshtein 1966).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that the user most likely meant by `word`; nothing when none is near. The first of equals.
[[nodiscard]] std::optional<std::string> nearest_word(std::string_view word, std::span<const std::string> candidates);

}  // namespace scanknit
