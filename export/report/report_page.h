// report.html: a run's report for a person, in one file without scripts that opens from disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// A picture for the page, as the bytes of a PNG file.
struct PagePicture {
  std::string kind;  ///< "preview", "error", "coverage", or "pair 1 2" of scans that were brought together
  std::vector<std::byte> png;
};

/// The page of one report.json, of this version or an earlier one: what it lacks is left out. Every string in it is
/// shown as text, whatever it holds. `trajectory`: in the TUM format, may be empty. Pictures are shrunk, and left out
/// when they are no PNG. Errors: kInput when `report_json` is no JSON object.
[[nodiscard]] Result<std::string> report_page(std::string_view report_json, std::string_view trajectory,
                                              std::span<const PagePicture> pictures);

/// Whether it is a report, of this version or an earlier one: has `version`, `status` and `exit_code`, and none of the
/// keys that a report may have is of another type (null is none). Errors: kInput, naming the first that is wrong.
[[nodiscard]] Result<void> check_report(std::string_view report_json);

/// Draws it with the pictures that lie in `page`'s folder, by the names that the report has for them, and the poses of
/// `trajectory` (empty: of the file there that the report names), and writes it all or nothing. Errors: kInput,
/// kOutput.
[[nodiscard]] Result<void> write_report_page(std::string_view report_json, const std::filesystem::path& page,
                                             const std::filesystem::path& trajectory = {});

}  // namespace scanknit
