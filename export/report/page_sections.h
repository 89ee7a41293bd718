// The sections of report.html, each from its part of report.json; empty where the report has nothing for it.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "export/report/page_text.h"

namespace scanknit {

/// The pictures of a page as data URIs, by kind.
using PageUris = std::map<std::string, std::string>;

/// What it is, how it ended, and the few numbers that most people want.
[[nodiscard]] std::string page_head(const PageJson& report);

[[nodiscard]] std::string pictures_section(const PageJson& report, const PageUris& pictures);
[[nodiscard]] std::string path_section(const PageJson& report, std::string_view trajectory);
[[nodiscard]] std::string holes_section(const PageJson& report);
[[nodiscard]] std::string finish_section(const PageJson& report);
[[nodiscard]] std::string tracking_section(const PageJson& report);
[[nodiscard]] std::string turntable_section(const PageJson& report);
[[nodiscard]] std::string alignment_section(const PageJson& report, const PageUris& pictures);
[[nodiscard]] std::string losses_section(const PageJson& report);
[[nodiscard]] std::string topology_section(const PageJson& report);
[[nodiscard]] std::string times_section(const PageJson& report);
[[nodiscard]] std::string files_section(const PageJson& report);
[[nodiscard]] std::string config_section(const PageJson& report);

}  // namespace scanknit
