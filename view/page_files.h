// The page of the live view, as files inside the program.
#pragma once

#include <span>
#include <string_view>

namespace scanknit {

struct PageFile {
  std::string_view path;  ///< in the address: "/view.js"
  std::string_view type;  ///< for the Content-Type header
  std::string_view bytes;
};

[[nodiscard]] std::span<const PageFile> page_files();

}  // namespace scanknit
