// report.html: a run's report to read, as one file without scripts that opens from disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// A picture for the page, as the bytes of a PNG file.
struct PagePicture {
  std::string kind;  ///< "preview", "error", "coverage", "pair 1 2" of aligned scans, or "class 3"
  std::vector<std::byte> png;
};

/// Makes the page of one report.json, of this version or an earlier one; omits what the report lacks. Escapes all its
/// strings. `trajectory`: in the TUM format, may be empty. Shrinks the pictures, and omits those that are no PNG.
/// Errors: kInput when `report_json` is no JSON object.
[[nodiscard]] Result<std::string> report_page(std::string_view report_json, std::string_view trajectory,
                                              std::span<const PagePicture> pictures);

/// Checks that the JSON is a report, of this version or an earlier one: it has `version`, `status` and `exit_code`, and
/// no known key has a wrong type (null is allowed). Errors: kInput, with the first wrong key.
[[nodiscard]] Result<void> check_report(std::string_view report_json);

/// Makes the page with the pictures in its folder, by the names in the report, and with the poses of `trajectory`
/// (in the TUM format; nothing: of the file in that folder that the report names). Writes it all or nothing. Errors:
/// kInput, kOutput.
[[nodiscard]] Result<void> write_report_page(std::string_view report_json, const std::filesystem::path& page,
                                             const std::optional<std::string>& trajectory = std::nullopt);

}  // namespace scanknit
