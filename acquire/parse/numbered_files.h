// The files of a folder whose names carry a frame number.
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>

#include "acquire/replay/folder.h"
#include "acquire/replay/numbered_name.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

using NumberedFiles = std::map<std::uint64_t, std::filesystem::path>;

/// "PREFIX number SUFFIX". Of files of one number the first is taken. Errors: those of list_folder.
[[nodiscard]] inline Result<NumberedFiles> numbered_files(const std::filesystem::path& folder, std::string_view prefix,
                                                          std::initializer_list<std::string_view> suffixes,
                                                          const Limits& limits) {
  const auto listing = list_folder(folder, limits);
  if (!listing) return listing.error();
  NumberedFiles files;
  for (const std::string& name : listing->files) {
    for (const std::string_view suffix : suffixes) {
      if (const auto number = numbered_name(name, prefix, suffix)) files.emplace(*number, folder / name);
    }
  }
  return files;
}

/// The same of the folder `name` in `folder`; none where there is no such folder.
[[nodiscard]] inline Result<NumberedFiles> numbered_files_below(const Folder& folder, const char* name,
                                                                std::string_view prefix,
                                                                std::initializer_list<std::string_view> suffixes,
                                                                const Limits& limits) {
  if (!folder.has_folder(name)) return NumberedFiles();
  return numbered_files(folder.path / name, prefix, suffixes, limits);
}

/// The file of this number; empty: there is none.
[[nodiscard]] inline std::filesystem::path file_of(const NumberedFiles& files, std::uint64_t number) {
  const auto found = files.find(number);
  return found == files.end() ? std::filesystem::path() : found->second;
}

}  // namespace scanknit
