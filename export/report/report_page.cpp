#include "export/report/report_page.h"

#include <fmt/format.h>

#include <exception>
#include <system_error>

#include "core/files/atomic_file.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "export/report/page_pictures.h"
#include "export/report/page_text.h"
#include "export/report/page_values.h"

namespace scanknit {
namespace {

constexpr int kPictureColumns = 1280;
constexpr int kPairColumns = 560;
constexpr std::uintmax_t kMostPictureBytes = 32u << 20;

PageUris uris_of(std::span<const PagePicture> pictures) {
  PageUris uris;
  for (const PagePicture& picture : pictures) {
    const bool is_one_of_many = picture.kind.starts_with("pair ") || picture.kind.starts_with("class ");
    uris[picture.kind] = picture_uri(picture.png, is_one_of_many ? kPairColumns : kPictureColumns);
  }
  return uris;
}

/// The file in `folder` that a report names, wherever it was when the report was written; empty when it is not there.
std::string bytes_beside(const std::filesystem::path& folder, const std::string& named, std::uintmax_t most) {
  const std::filesystem::path name = std::filesystem::path(named).filename();
  if (name.empty() || name == "." || name == "..") return "";
  auto bytes = read_text_file(folder / name, most);
  return bytes ? *std::move(bytes) : std::string();
}

std::vector<PagePicture> pictures_beside(const std::filesystem::path& folder, const ReportJson& report) {
  std::vector<PagePicture> pictures;
  const auto add = [&](const std::string& kind, const std::string& named) {
    const std::string bytes = bytes_beside(folder, named, kMostPictureBytes);
    const auto raw = std::as_bytes(std::span(bytes));
    if (!bytes.empty()) pictures.push_back({kind, {raw.begin(), raw.end()}});
  };
  for (const char* kind : {"preview", "error", "coverage"}) add(kind, text_at(report, std::string("/files/") + kind));
  const ReportJson& pairs = list_at(report, "/alignment/pairs");
  for (std::size_t i = 0; i < std::min(pairs.size(), kMostPairPictures); ++i) {
    const auto scan = [&](const char* pointer) { return grouped_digits(number_at(pairs[i], pointer).value_or(0)); };
    add("pair " + scan("/from") + " " + scan("/to"), text_at(pairs[i], "/picture"));
  }
  const ReportJson& classes = list_at(report, "/classes");
  for (std::size_t i = 0; i < std::min(classes.size(), kMostClassPictures); ++i) {
    const double label = number_at(classes[i], "/class").value_or(0);
    add("class " + grouped_digits(label), text_at(classes[i], fmt::format("/files/preview_class{:.0f}", label)));
  }
  return pictures;
}

}  // namespace

Result<std::string> report_page(std::string_view report_json, std::string_view trajectory,
                                std::span<const PagePicture> pictures) {
  const auto report = parse_report(report_json);
  if (!report) return report.error();
  return filled_page(*report, trajectory, uris_of(pictures));
}

Result<void> check_report(std::string_view report_json) {
  const auto report = parse_report(report_json);
  if (!report) return report.error();
  const auto wrong = [](const char* key, const char* type) {
    return Error{ErrorCode::kInput, fmt::format("is no report of scanknit: `{}` is no {}", key, type)};
  };
  for (const char* key : {"version", "status", "exit_code"}) {
    if (!report->contains(key)) return Error{ErrorCode::kInput, fmt::format("is no report of scanknit: no `{}`", key)};
  }
  if (!(*report)["exit_code"].is_number_integer()) return wrong("exit_code", "whole number");
  for (const char* key : {"version", "status", "input"}) {
    if (report->contains(key) && !(*report)[key].is_string()) return wrong(key, "text");
  }
  const auto is_missing = [&](const char* key) { return !report->contains(key) || (*report)[key].is_null(); };
  for (const char* key : {"total_ms", "peak_rss_mib"}) {
    if (!is_missing(key) && !(*report)[key].is_number()) return wrong(key, "number");
  }
  for (const char* key : {"warnings", "classes"}) {
    if (!is_missing(key) && !(*report)[key].is_array()) return wrong(key, "list");
  }
  for (const char* key : {"frames", "losses", "tracking", "turntable", "alignment", "stages", "volume", "silhouettes",
                          "mesh", "holes", "doubled", "fit", "extract", "finish", "texture", "files", "config"}) {
    if (!is_missing(key) && !(*report)[key].is_object()) return wrong(key, "object");
  }
  return {};
}

Result<void> write_report_page(std::string_view report_json, const std::filesystem::path& page,
                               const std::optional<std::string>& trajectory) {
  const auto report = parse_report(report_json);
  if (!report) return report.error();
  const std::filesystem::path folder = page.parent_path();
  const std::string poses =
      trajectory ? *trajectory : bytes_beside(folder, text_at(*report, "/files/trajectory"), Limits{}.max_text_bytes);
  return write_file_atomically(page, filled_page(*report, poses, uris_of(pictures_beside(folder, *report))));
}

}  // namespace scanknit
