// KeyedNumbers: what a small file of YAML or XML says of cameras. Private to the room.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// Values by their whole key: "left.fx" is fx within left. A list of lists is one list, row by row. A value is in
/// `numbers` where all its words are numbers, else in `texts`.
struct KeyedNumbers {
  std::map<std::string, std::vector<double>, std::less<>> numbers;
  std::map<std::string, std::string, std::less<>> texts;

  /// Null: there is no such key, or `count` is not 0 and the list has another length.
  [[nodiscard]] const std::vector<double>* find(std::string_view key, std::size_t count = 0) const;
  [[nodiscard]] std::optional<double> number(std::string_view key) const;
};

/// Reads what OpenCV, Kalibr, EuRoC's files and people write: keys with numbers, texts, maps and lists, in the styles
/// of blocks and of brackets; or OpenCV's XML. Of other YAML (anchors, folded texts) nothing is understood. Errors
/// (kInput, without `where`): brackets that do not close, nesting deeper than 8, more than 1 MB.
[[nodiscard]] Result<KeyedNumbers> parse_keyed_numbers(std::string_view text);

}  // namespace scanknit
