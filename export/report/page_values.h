// Fills report.html.mustache with the values of a report. Private to report_page.cpp.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "export/report/page_json.h"

namespace scanknit {

inline constexpr std::size_t kMostPairPictures = 12, kMostClassPictures = 32;

/// The pictures of a page as data URIs, by kind (PagePicture::kind); empty for pictures that cannot be shown.
using PageUris = std::map<std::string, std::string>;

/// The whole page. `trajectory`: in the TUM format, may be empty.
[[nodiscard]] std::string filled_page(const ReportJson& report, std::string_view trajectory, const PageUris& pictures);

}  // namespace scanknit
