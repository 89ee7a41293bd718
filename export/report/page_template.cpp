#include "export/report/page_template.h"

#include <algorithm>

namespace scanknit {
namespace {

bool is_only_a_tag(std::string_view line) {
  const bool is_tag = line.starts_with("{{#") || line.starts_with("{{^") || line.starts_with("{{/");
  return is_tag && line.find("}}") == line.size() - 2;
}

}  // namespace

std::string page_template() {
  std::string text;
  std::string_view source = kPageTemplate;
  for (bool is_joined = false; !source.empty();) {
    std::string_view line = source.substr(0, source.find('\n'));
    source.remove_prefix(std::min(line.size() + 1, source.size()));
    if (is_joined) line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
    is_joined = line.ends_with('\\');
    text += line.substr(0, line.size() - (is_joined ? 1 : 0));
    if (!is_joined && !is_only_a_tag(line)) text += '\n';
  }
  return text;
}

}  // namespace scanknit
