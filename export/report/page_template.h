// report.html.mustache, which is built into the library.
#pragma once

#include <string>
#include <string_view>

namespace scanknit {

/// The file as it is.
extern const std::string_view kPageTemplate;

/// The template without the line breaks that only make it readable: those after a backslash, with the spaces that
/// follow, and those after a tag that is alone on its line. (Mustache's rules remove the latter, too, but the library
/// keeps them when the tag's section is not rendered.)
[[nodiscard]] std::string page_template();

}  // namespace scanknit
