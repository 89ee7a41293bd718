#include "acquire/bag/bag_metadata.h"

#include <algorithm>

#include "acquire/parse/quoted_text.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostFiles = 10'000;

/// "[a, b]".
std::vector<std::string> names_in_brackets(std::string_view text) {
  std::vector<std::string> names;
  text = text.substr(1, text.find(']') - 1);
  while (!text.empty() && names.size() < kMostFiles) {
    const auto comma = std::min(text.find(','), text.size());
    if (const auto name = without_quotes(text.substr(0, comma)); !name.empty()) names.emplace_back(name);
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
    const std::string_view line = without_blanks(yaml.substr(0, end));
    if (is_first && line.starts_with('[')) return names_in_brackets(without_blanks(yaml.substr(yaml.find('['))));
    if (line.starts_with("- ")) {
      names.emplace_back(without_quotes(line.substr(2)));
    } else if (!line.empty() && !line.starts_with('#')) {
      break;  // the next key
    }
    if (end == yaml.size()) break;
    yaml.remove_prefix(end + 1);
  }
  return names;
}

}  // namespace scanknit
