// A YAML document as a plain tree, with the line and column of every node; keeps repeated keys.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace scanknit {

struct YamlNode {
  enum class Kind { kNull, kScalar, kSequence, kMap };
  Kind kind = Kind::kNull;
  int line = 1;                    ///< from 1
  int column = 1;                  ///< from 1, in bytes
  std::string text;                ///< of a scalar
  std::vector<YamlNode> children;  ///< of a sequence: the items; of a map: key, value, key, value ...
};

struct YamlError {
  int line = 1;
  int column = 1;
  std::string message;
};

/// Parses one document. Errors: anchors and aliases (they can expand a few bytes into gigabytes), nesting deeper than
/// 16, a second document, tabs as indentation, and anything that is not YAML. Never throws. An empty text gives a kNull
/// node.
[[nodiscard]] std::variant<YamlNode, YamlError> parse_yaml(std::string_view text);

}  // namespace scanknit
