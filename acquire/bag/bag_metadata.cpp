#include "acquire/bag/bag_metadata.h"

#include <algorithm>

namespace scanknit {
namespace {

constexpr std::size_t kMostFiles = 10'000;

std::string_view trimmed(std::string_view text) {
  constexpr const char* kBlank = " \t\r";
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// A name as YAML writes it: plain, or in quotes.
std::string plain_name(std::string_view text) {
  text = trimmed(text);
  const bool is_quoted =
      text.size() >= 2 && text.front() == text.back() && (text.front() == '"' || text.front() == '\'');
  return std::string(is_quoted ? text.substr(1, text.size() - 2) : text);
}

/// "[a, b]".
std::vector<std::string> names_in_brackets(std::string_view text) {
  std::vector<std::string> names;
  text = text.substr(1, text.find(']') - 1);
  while (!text.empty() && names.size() < kMostFiles) {
    const auto comma = std::min(text.find(','), text.size());
    if (auto name = plain_name(text.substr(0, comma)); !name.empty()) names.push_back(std::move(name));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return names;
}

}  // namespace

bool is_bag_metadata(std::string_view yaml) {
  return yaml.find("rosbag2_bagfile_information:") != std::string_view::npos;
}

std::vector<std::string> files_of_bag(std::string_view yaml) {
  constexpr std::string_view kKey = "relative_file_paths:";
  std::vector<std::string> names;
  const auto key = yaml.find(kKey);
  if (key == std::string_view::npos) return names;
  yaml.remove_prefix(key + kKey.size());
  for (bool is_first = true; names.size() < kMostFiles; is_first = false) {
    const auto end = std::min(yaml.find('\n'), yaml.size());
    const std::string_view line = trimmed(yaml.substr(0, end));
    if (is_first && line.starts_with('[')) return names_in_brackets(trimmed(yaml.substr(yaml.find('['))));
    if (line.starts_with("- ")) {
      names.push_back(plain_name(line.substr(2)));
    } else if (!line.empty() && !line.starts_with('#')) {
      break;  // the next key
    }
    if (end == yaml.size()) break;
    yaml.remove_prefix(end + 1);
  }
  return names;
}

}  // namespace scanknit
