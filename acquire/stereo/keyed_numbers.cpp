#include "acquire/stereo/keyed_numbers.h"

#include <algorithm>
#include <utility>

#include "acquire/parse/quoted_text.h"
#include "core/files/ascii_numbers.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostBytes = 1u << 20;
constexpr std::size_t kMostLevels = 8;
constexpr std::size_t kLongestKey = 100;

Error keyed_error(std::string message) {
  return {ErrorCode::kInput, std::move(message)};
}

/// Brackets, commas and blanks divide numbers; nothing if a word is no number.
std::optional<std::vector<double>> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  constexpr const char* kBetween = "[], \t\r\n";
  for (;;) {
    const auto begin = text.find_first_not_of(kBetween);
    if (begin == std::string_view::npos) return numbers;
    text.remove_prefix(begin);
    std::string_view word = text.substr(0, text.find_first_of(kBetween));
    text.remove_prefix(word.size());
    if (word.size() > 1 && word.back() == '.') word.remove_suffix(1);  // "1." as OpenCV writes it
    const auto number = parse_double(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
}

void keep_value(const std::string& key, std::string_view value, KeyedNumbers& keyed) {
  value = without_blanks(value);
  if (const auto numbers = numbers_in(value); numbers && !value.empty()) {
    auto& list = keyed.numbers[key];
    list.insert(list.end(), numbers->begin(), numbers->end());
  } else {
    keyed.texts.insert_or_assign(key, std::string(without_quotes(value)));
  }
}

/// The lines without comments and without what is not content ("---", "%YAML").
std::string content_of_yaml(std::string_view text) {
  std::string content;
  while (!text.empty()) {
    std::string_view line = take_line(text);
    const bool is_mark = line.starts_with("---") || line.starts_with("...") || line.starts_with('%');
    if (is_mark) line = {};
    for (std::size_t at = 0; at < line.size(); ++at) {
      if (line[at] == '#' && (at == 0 || line[at - 1] == ' ' || line[at - 1] == '\t')) line = line.substr(0, at);
    }
    content += line;
    content += '\n';
  }
  return content;
}

class YamlNumbers {
 public:
  explicit YamlNumbers(std::string_view content) : rest_(content) {}

  [[nodiscard]] Result<KeyedNumbers> read() && {
    while (!rest_.empty()) {
      if (auto done = read_line(); !done) return done.error();
    }
    return std::move(keyed_);
  }

 private:
  struct Level {
    std::size_t indent;
    std::string key;
  };

  [[nodiscard]] Result<void> read_line() {
    const std::size_t indent = std::min(rest_.find_first_not_of(' '), rest_.size());
    const std::string_view line = rest_.substr(indent, rest_.find('\n', indent) - indent);
    if (without_blanks(line).empty()) {
      skip_line();
      return {};
    }
    if (line.starts_with("- ")) return read_item(indent + 1);
    const auto colon = end_of_key(line);
    if (colon == std::string_view::npos) {
      skip_line();
      return {};
    }
    while (!levels_.empty() && levels_.back().indent >= indent) levels_.pop_back();
    if (levels_.size() == kMostLevels) return keyed_error("keys are nested too deep to be a camera's");
    if (colon > kLongestKey) return keyed_error("a key is too long to be a camera's");
    levels_.push_back({indent, path_of(without_quotes(line.substr(0, colon)))});
    rest_.remove_prefix(indent + colon + 1);
    return read_value();
  }

  /// An item of a list, which stands on a line of its own.
  [[nodiscard]] Result<void> read_item(std::size_t before) {
    rest_.remove_prefix(before);
    if (!levels_.empty()) return read_value();
    skip_line();
    return {};
  }

  void skip_line() { rest_.remove_prefix(std::min(rest_.find('\n'), rest_.size() - 1) + 1); }

  [[nodiscard]] static std::size_t end_of_key(std::string_view line) {
    for (std::size_t at = 0; at < line.size(); ++at) {
      if (line[at] == ':' && (at + 1 == line.size() || line[at + 1] == ' ' || line[at + 1] == '\r')) return at;
    }
    return std::string_view::npos;
  }

  [[nodiscard]] std::string path_of(std::string_view key) const {
    return levels_.empty() ? std::string(key) : levels_.back().key + '.' + std::string(key);
  }

  /// What follows a key or a dash: to the end of the line, or of the brackets that begin there.
  [[nodiscard]] Result<void> read_value() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size()));
    if (rest_.starts_with("!!")) rest_.remove_prefix(std::min(rest_.find_first_of(" \r\n"), rest_.size()));
    rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size()));
    const std::string& key = levels_.back().key;
    if (!rest_.starts_with('[') && !rest_.starts_with('{')) {
      const std::string_view value = without_blanks(take_line(rest_));
      if (!value.empty()) keep_value(key, value, keyed_);
      return {};
    }
    const auto length = length_of_brackets(rest_);
    if (!length) return keyed_error("the brackets after '" + key + "' do not close");
    const std::string_view value = rest_.substr(0, *length);
    rest_.remove_prefix(*length);
    if (value.front() == '[') {
      keep_value(key, value, keyed_);
    } else {
      keep_map(key, value.substr(1, value.size() - 2));
    }
    return {};
  }

  [[nodiscard]] static std::optional<std::size_t> length_of_brackets(std::string_view text) {
    std::size_t open = 0;
    for (std::size_t at = 0; at < text.size(); ++at) {
      if (text[at] == '[' || text[at] == '{') ++open;
      if ((text[at] == ']' || text[at] == '}') && --open == 0) return at + 1;
    }
    return std::nullopt;
  }

  /// "fx: 1, distortion: [1, 2]": commas within brackets do not divide. Maps within maps are not read.
  void keep_map(const std::string& key, std::string_view map) {
    while (!map.empty()) {
      std::size_t end = 0;
      for (int open = 0; end < map.size() && (open > 0 || map[end] != ','); ++end) {
        open += map[end] == '[' ? 1 : map[end] == ']' ? -1 : 0;
      }
      const std::string_view part = map.substr(0, end);
      map.remove_prefix(std::min(end + 1, map.size()));
      const auto colon = part.find(':');
      if (colon == std::string_view::npos || colon > kLongestKey) continue;
      keep_value(key + '.' + std::string(without_quotes(part.substr(0, colon))), part.substr(colon + 1), keyed_);
    }
  }

  std::string_view rest_;
  std::vector<Level> levels_;
  KeyedNumbers keyed_;
};

/// Tags within <opencv_storage>; attributes are not needed.
Result<KeyedNumbers> read_xml_numbers(std::string_view text) {
  KeyedNumbers keyed;
  std::vector<std::string> path;
  while (!text.empty()) {
    const auto open = std::min(text.find('<'), text.size());
    const std::string_view content = without_blanks(text.substr(0, open));
    if (!content.empty() && !path.empty()) keep_value(path.back(), content, keyed);
    const auto close = text.find('>', open);
    if (close == std::string_view::npos) break;
    const std::string_view tag = text.substr(open + 1, close - open - 1);
    text.remove_prefix(close + 1);
    if (tag.starts_with('?') || tag.starts_with('!') || tag.ends_with('/')) continue;
    if (tag.starts_with('/')) {
      if (!path.empty()) path.pop_back();
      continue;
    }
    const std::string name(tag.substr(0, tag.find_first_of(" \t\r\n")));
    if (name == "opencv_storage") continue;
    if (path.size() == kMostLevels) return keyed_error("tags are nested too deep to be a camera's");
    if (name.size() > kLongestKey) return keyed_error("a tag is too long to be a camera's");
    path.push_back(path.empty() ? name : path.back() + '.' + name);
  }
  return keyed;
}

}  // namespace

const std::vector<double>* KeyedNumbers::find(std::string_view key, std::size_t count) const {
  const auto found = numbers.find(key);
  if (found == numbers.end()) return nullptr;
  return count == 0 || found->second.size() == count ? &found->second : nullptr;
}

std::optional<double> KeyedNumbers::number(std::string_view key) const {
  const auto* list = find(key, 1);
  return list != nullptr ? std::optional(list->front()) : std::nullopt;
}

Result<KeyedNumbers> parse_keyed_numbers(std::string_view text) {
  if (text.size() > kMostBytes) return keyed_error("larger than a file of cameras is");
  if (without_blanks(text).starts_with('<')) return read_xml_numbers(text);
  const std::string content = content_of_yaml(text);
  return YamlNumbers(content).read();
}

}  // namespace scanknit
