// report.html.mustache, which is built into the library.
#pragma once

#include <string>
#include <string_view>

namespace scanknit {

/// The file as it is.
extern const std::string_view kPageTemplate;

/// The template without the line breaks that are only there to read it: the one behind a backslash, with the spaces
/// that follow, and the one behind a tag that has the line for itself. (Mustache's rules take the latter away, too, but
/// the library keeps it where the tag's section is left out.)
[[nodiscard]] std::string page_template();

}  // namespace scanknit
