// The files of the live view's page, embedded in the program.
#pragma once

#include <span>
#include <string_view>

namespace scanknit {

struct PageFile {
  std::string_view path;  ///< path in the URL: "/view.js"
  std::string_view type;  ///< for the Content-Type header
  std::string_view bytes;
};

[[nodiscard]] std::span<const PageFile> page_files();

}  // namespace scanknit
