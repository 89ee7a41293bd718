#include "view/page_files.h"

#include <array>

// The built files, from page_bytes.S.
extern "C" {
extern const char scanknit_index_html_begin[], scanknit_index_html_end[];
extern const char scanknit_view_js_begin[], scanknit_view_js_end[];
extern const char scanknit_view_css_begin[], scanknit_view_css_end[];
extern const char scanknit_icon_svg_begin[], scanknit_icon_svg_end[];
}

namespace scanknit {
namespace {

std::string_view bytes_between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::span<const PageFile> page_files() {
  static const std::array<PageFile, 4> files = {{
      {"/", "text/html; charset=utf-8", bytes_between(scanknit_index_html_begin, scanknit_index_html_end)},
      {"/view.js", "text/javascript; charset=utf-8", bytes_between(scanknit_view_js_begin, scanknit_view_js_end)},
      {"/view.css", "text/css; charset=utf-8", bytes_between(scanknit_view_css_begin, scanknit_view_css_end)},
      {"/icon.svg", "image/svg+xml", bytes_between(scanknit_icon_svg_begin, scanknit_icon_svg_end)},
  }};
  return files;
}

}  // namespace scanknit
